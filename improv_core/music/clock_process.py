"""The parent's side of the process that follows a music clock, MIDI or Ableton Link. Standard library only."""

from __future__ import annotations

import asyncio
import subprocess
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Literal, TypedDict, cast

from improv_core.ipc.child import Child, Policy
from improv_core.protocol.clock_messages import FromClock
from improv_core.protocol.decoding import ProtocolError, read_as
from improv_core.protocol.limits import helper
from improv_core.score.score import OutsideClock

POLICY = Policy(1.0, errors=subprocess.PIPE)


class ClockGone(TypedDict):
    """The process has ended by itself. Its parent makes this message, with the reason unless the process gave it."""

    type: Literal["clock_gone"]
    message: str


HeardClock = FromClock | ClockGone
"""A message from a music clock."""


class ClockProcess:
    """Started with a running event loop, on which `hear` gets the messages. `tempo`, in beats per minute, is the tempo
    of a session without other members. Raises OSError."""

    def __init__(self, clock: OutsideClock, tempo: float, hear: Callable[[HeardClock], None]) -> None:
        self._hear = hear
        self._loop = asyncio.get_running_loop()
        self._closing = self._explained = False
        self._child = Child(helper(clock.follow, clock.port, f"{tempo:g}"), POLICY)
        threading.Thread(target=self._read, daemon=True).start()

    def close(self) -> None:
        """End the process. `hear` gets nothing more."""
        self._closing = True
        self._child.close_input()

    def _read(self) -> None:
        with suppress(EOFError):
            while True:
                for line in self._child.read():
                    with suppress(ProtocolError):
                        self._pass_on(cast(FromClock, read_as(line, FromClock)))
        self._child.close_input()
        self._child.wait()
        why = "" if self._explained else self._child.last_error or "it ended by itself"
        self._pass_on({"type": "clock_gone", "message": why})

    def _pass_on(self, message: HeardClock) -> None:
        self._explained |= message["type"] == "error"
        with suppress(RuntimeError):  # the loop was closed
            self._loop.call_soon_threadsafe(self._deliver, message)

    def _deliver(self, message: HeardClock) -> None:
        if not self._closing:
            self._hear(message)
