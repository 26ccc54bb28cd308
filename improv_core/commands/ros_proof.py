"""The proof that a ROS 2 works: a Twist from a real stage to a listener in another process."""

from __future__ import annotations

import asyncio
import contextlib
import json
import os
import time
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path

from improv_core.commands.ros_environment import AGAIN, ELSEWHERE, Say, SetupError
from improv_core.playback.isolation import isolated
from improv_core.playback.stage_process import Heard, Stage, StageError
from improv_core.playback.stops import Stops
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.score_json import to_json
from improv_core.stage.discovery import PEERS, RANGE, limited
from improv_core.stage.messages import FOLDER

LIMIT = 60.0
"""Seconds the Twist may take to arrive, including everything that has to start for it."""
DOMAIN = "101"
"""The last domain that does not collide with Linux's ephemeral ports: few robots use it."""


def prove(python: Path, say: Say) -> None:
    """Send a Twist from a real stage to a listener in another process. Raises SetupError."""
    env = limited({**os.environ, RANGE: "LOCALHOST", PEERS: "", "ROS_DOMAIN_ID": DOMAIN})
    try:
        seconds = asyncio.run(asyncio.wait_for(_sent_and_received(str(python), env), LIMIT))
    except asyncio.TimeoutError:
        raise SetupError(
            "ROS 2 starts, but a Twist does not arrive: make the firewall allow UDP on this machine's own addresses, "
            f"then {AGAIN}"
        ) from None
    except (StageError, OSError) as error:
        raise SetupError(f"ROS 2 does not start ({error}): {AGAIN}, or {ELSEWHERE}") from None
    say(f"ROS 2 works: a Twist was sent and received in {seconds:.1f} s")


async def _sent_and_received(python: str, env: Mapping[str, str]) -> float:
    """Seconds from loading the score until its first Twist arrives, including discovery."""
    robot = f"improv_setup_{os.getpid()}"  # not the name of any robot, so that none moves
    score = score_of(analyze(f"{robot} $ forward\n"))
    failed: asyncio.Future[None] = asyncio.get_running_loop().create_future()

    def hear(_: Stage, message: Heard, stops: int) -> None:
        if (message["type"] == "error" or message["type"] == "gone") and not failed.done():
            failed.set_exception(StageError(message["message"]))

    async with _receiver([python, str(FOLDER / "graph.py"), "receive", score.parts[robot].topic], env) as lines:
        sender = await Stage.start([python, str(FOLDER), "--sink", "ros"], env, hear, Stops())
        try:
            began = time.monotonic()
            sender.send(
                {"type": "load", "generation": 1, "score": to_json(score), "when": "restart", "backend": "the proof"}
            )
            received = asyncio.create_task(_next(lines))
            await asyncio.wait([received, failed], return_when=asyncio.FIRST_COMPLETED)
            for each in (received, failed):
                if each.done():
                    each.result()
                each.cancel()
            return time.monotonic() - began
        finally:
            await sender.close()


@asynccontextmanager
async def _receiver(command: Sequence[str], env: Mapping[str, str]) -> AsyncIterator[asyncio.StreamReader]:
    """A process that listens, until the context ends."""
    pipe, nothing = asyncio.subprocess.PIPE, asyncio.subprocess.DEVNULL
    process = await asyncio.create_subprocess_exec(
        *command, stdin=nothing, stdout=pipe, stderr=nothing, **isolated(env)
    )
    try:
        assert process.stdout
        await _next(process.stdout)
        yield process.stdout
    finally:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
        await process.wait()


async def _next(lines: asyncio.StreamReader) -> None:
    """Wait for the next step that a receiver reports."""
    if not json.loads(await lines.readline() or "false"):
        raise StageError("its listener ended")
