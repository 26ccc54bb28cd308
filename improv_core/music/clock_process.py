"""The parent's side of the process that follows a music clock, MIDI or Ableton Link. Standard library only."""

from __future__ import annotations

import asyncio
import subprocess
from collections.abc import Callable
from contextlib import suppress
from typing import Literal, TypedDict

from improv_core.ipc.child import Policy
from improv_core.ipc.helper import Helper
from improv_core.protocol.helper_messages import FromClock
from improv_core.protocol.limits import helper_command
from improv_core.score.score import OutsideClock

POLICY = Policy(1.0, errors=subprocess.PIPE)


class ClockGone(TypedDict):
    """The process has ended by itself. `message` has the reason; it is empty if the process has reported it."""

    type: Literal["clock_gone"]
    message: str


HeardClock = FromClock | ClockGone
"""A message from a music clock."""


class ClockProcess:
    """Started with a running event loop, on which `hear` gets the messages. `tempo`, in beats per minute, is the tempo
    of a session without other members."""

    def __init__(self, clock: OutsideClock, tempo: float, hear: Callable[[HeardClock], None]) -> None:
        self._hear = hear
        self._loop = asyncio.get_running_loop()
        self._closing = self._explained = False
        command = helper_command(f"music.{clock.follow}", clock.port, f"{tempo:g}")
        self._process = Helper(command, POLICY, FromClock, self._pass_on, self._end)

    def close(self) -> None:
        """End the process. `hear` gets nothing more."""
        self._closing = True
        self._process.close()

    def _end(self, why: str) -> None:
        self._pass_on({"type": "clock_gone", "message": "" if self._explained else why or "it ended by itself"})

    def _pass_on(self, message: HeardClock) -> None:
        self._explained |= message["type"] == "error"
        with suppress(RuntimeError):  # the loop was closed
            self._loop.call_soon_threadsafe(self._deliver, message)

    def _deliver(self, message: HeardClock) -> None:
        if not self._closing:
            self._hear(message)
