"""All stages as one, with the real simulator."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

import pytest

from improv_core.playback.playback import News, Options, Playback
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.stage.protocol import TransportMessage

LIMIT = 60.0
ENDLESS = score_of(analyze("r $ repeat forward\n"))


class Performance:
    """A playback, and what its stage says."""

    def __init__(self) -> None:
        self.playback = Playback(Options("sim"), self._hear)
        self._told: asyncio.Queue[News] = asyncio.Queue()

    async def transport(self) -> TransportMessage:
        """The next one."""
        while (message := await asyncio.wait_for(self._told.get(), LIMIT))["type"] != "transport":
            pass
        return message

    def _hear(self, message: News, leads: bool) -> None:
        self._told.put_nowait(message)


def check(performs: Callable[[Performance], Awaitable[None]]) -> None:
    async def run() -> None:
        performance = Performance()
        try:
            await performs(performance)
        finally:
            await performance.playback.close()

    asyncio.run(run())


@pytest.mark.parametrize("ends", [False, True])
def test_nothing_plays_that_was_stopped_while_the_stages_started(ends: bool) -> None:
    async def performs(performance: Performance) -> None:
        playback = performance.playback
        playing = asyncio.ensure_future(playback.play(ENDLESS))
        await asyncio.sleep(0)  # it is on its way
        if ends:
            await playback.close()
        else:
            playback.conduct({"type": "hush"})
        assert await playing is None
        assert await playback.play(ENDLESS) == 1
        assert (await performance.transport())["state"] == "playing"

    check(performs)


def test_who_stands_still_and_how_fast_the_others_are_outlives_a_playback() -> None:
    async def performs(performance: Performance) -> None:
        old = Playback(Options("sim"), lambda message, leads: None)
        old.silence(["r"], [])
        old.conduct({"type": "speed", "factor": 2.0})
        performance.playback.keep_as(old)
        assert performance.playback.muted == {"r"}
        await performance.playback.play(ENDLESS)
        while (transport := await performance.transport())["state"] != "playing":
            pass
        assert (transport["muted"], transport["speed"]) == (["r"], 2)

    check(performs)
