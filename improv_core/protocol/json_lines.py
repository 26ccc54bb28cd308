"""The JSON lines that a child process reads and writes; `child.py` is the other side. Standard library only."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any, Generic, Literal, TypedDict, TypeVar

Message = TypeVar("Message")


class Alive(TypedDict):
    """The process that sends it lives."""

    type: Literal["alive"]


class Lines(Generic[Message]):
    """Messages on standard input: a JSON line each. Reading never waits. The end of the input ends the process; no
    signal does."""

    def __init__(self) -> None:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        os.set_blocking(0, False)
        self._rest = b""
        self.ended = False

    def read(self) -> Iterator[Message]:
        """Yield all messages that have arrived."""
        while not self.ended:
            try:
                data = os.read(0, 65_536)
            except BlockingIOError:
                return
            self.ended = not data
            *lines, self._rest = (self._rest + data).split(b"\n")
            yield from map(json.loads, lines)


def own_output() -> Callable[[Any], None]:
    """Take over standard output, and return a function that writes a message there as a JSON line.

    All other prints go to standard error from now on: a library that prints would break our lines.
    """
    ours = os.dup(1)
    os.dup2(2, 1)

    def say(message: Any) -> None:
        line = json.dumps(message).encode() + b"\n"
        with suppress(OSError):  # our parent is gone; the end of standard input shows that, too
            while line:
                line = line[os.write(ours, line) :]

    return say
