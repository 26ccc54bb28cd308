"""Watch the simulated robots as their page does: `python -m tests.editors.robot URL moves|stands`.

The URL has a ticket that nothing else has used, or the page's token.
"""

from __future__ import annotations

import asyncio
import math
import sys
import tempfile
import time
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from hashlib import sha256
from pathlib import Path

from aiohttp import ClientWebSocketResponse

from tests.open_page import connected, live_behind

LIMIT = 60.0
"""Seconds to wait for a robot on a busy machine."""
AWAY = 0.5
"""Meters from its first pose after which a robot counts as moved."""
STILL = 1.0
"""Seconds with the same pose after which a robot stands; a page gets every change within 1/60 s."""


async def moves(url: str) -> None:
    """Return once a robot has moved."""
    async with asyncio.timeout(LIMIT), _live(url) as live:
        start: dict[int, Sequence[float]] = {}
        async for poses in _poses(live):
            for name, pose in poses.items():
                if math.dist(pose[:3], start.setdefault(name, pose)[:3]) >= AWAY:
                    return


async def stands(url: str) -> None:
    """Return once all robots stand."""
    end = time.monotonic() + LIMIT - 2 * STILL  # before the other limit, which ends without a message
    async with asyncio.timeout(LIMIT), _live(url) as live:
        poses = _poses(live)
        assert (latest := await anext(poses)), "there is no robot"
        while True:
            assert time.monotonic() < end, f"robots still move, and are at {latest}"
            try:
                async with asyncio.timeout(STILL):
                    latest = await anext(poses)
            except TimeoutError:
                return


@asynccontextmanager
async def _live(url: str) -> AsyncIterator[ClientWebSocketResponse]:
    async with connected(await asyncio.to_thread(_address, url)) as socket:
        yield socket


def _address(url: str) -> str:
    """Return the address of the WebSocket. A ticket works once, so a file keeps the address for the next process."""
    if "?token=" in url:
        return url.replace("/?", "/live?")
    kept = Path(tempfile.gettempdir(), f"improv-robot-{sha256(url.encode()).hexdigest()}")
    if not kept.exists():
        kept.write_text(live_behind(url), encoding="utf-8")
    return kept.read_text(encoding="utf-8")


async def _poses(live: ClientWebSocketResponse) -> AsyncIterator[Mapping[int, Sequence[float]]]:
    """Yield x, y, z, and heading of each robot, whenever one has changed."""
    while True:
        message = await live.receive_json()
        if message["type"] == "poses":
            yield dict(enumerate(message["poses"]))  # in the order of the robots


if __name__ == "__main__":
    asyncio.run({"moves": moves, "stands": stands}[sys.argv[2]](sys.argv[1]))
