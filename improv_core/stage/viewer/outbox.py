"""What one page has yet to get, so that a slow page sees the present and holds nobody back."""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import Iterable
from contextlib import suppress
from typing import TYPE_CHECKING

from improv_core.stage.protocol import AskWindow, BumpJson, Bumps

if TYPE_CHECKING:
    from aiohttp import web

    from improv_core.stage.sinks.collisions import Bump

MOST_BUMPS = 200


class Outbox:
    """The latest message of each kind, and all bumps."""

    def __init__(self) -> None:
        self._waiting: dict[str, str] = {}
        self._bumps: deque[Bump] = deque(maxlen=MOST_BUMPS)
        self._filled = asyncio.Event()
        self._empty = asyncio.Event()
        self.asked: AskWindow | None = None
        """The latest question for a window that has not been looked at."""

    def put(self, kind: str, text: str) -> None:
        """Send a message, instead of one of its kind that still waits, and after all others."""
        self._waiting.pop(kind, None)
        self._waiting[kind] = text
        self._empty.clear()
        self._filled.set()

    def add_bumps(self, bumps: Iterable[Bump]) -> None:
        """Send bumps, with those that still wait."""
        self._bumps.extend(bumps)
        self.put("bumps", "")

    async def emptied(self) -> None:
        """Wait until the page has got everything."""
        await self._empty.wait()

    async def empty_into(self, page: web.WebSocketResponse) -> None:
        """Send everything there is, and what comes, without end."""
        while True:
            await self._filled.wait()
            self._filled.clear()
            while self._waiting:
                kind = next(iter(self._waiting))
                text = self._waiting.pop(kind)
                with suppress(ConnectionError):  # gone: the reading side ends the page
                    await page.send_str(text or self._take_bumps())
            self._empty.set()

    def _take_bumps(self) -> str:
        bumps = list(self._bumps)
        self._bumps.clear()
        return told(bumps, past=False)


def told(bumps: Iterable[Bump], past: bool) -> str:
    """The message that tells of bumps, or of all those in the past of a page that comes later."""
    rows: list[BumpJson] = [
        {"at": round(bump.at, 4), "x": round(bump.x, 4), "y": round(bump.y, 4), "robots": bump.robots} for bump in bumps
    ]
    message: Bumps = {"type": "bumps", "past": past, "bumps": rows}
    return json.dumps(message)
