"""The lines that a process of ours reads and writes; `child.py` is the other side. Standard library only."""

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
    """Messages on standard input: a JSON line each. Reading never waits. Their end ends the process, and no signal."""

    def __init__(self) -> None:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            signal.signal(number, signal.SIG_IGN)
        os.set_blocking(0, False)
        self._rest = b""
        self.ended = False

    def read(self) -> Iterator[Message]:
        """All messages that have arrived."""
        while not self.ended:
            try:
                data = os.read(0, 65_536)
            except BlockingIOError:
                return
            self.ended = not data
            *lines, self._rest = (self._rest + data).split(b"\n")
            yield from map(json.loads, lines)


def own_output() -> Callable[[Any], None]:
    """Make standard output ours alone, and return what writes a message there, a JSON line each.

    What anything else prints from now on goes to standard error: the text of a library would tear our lines.
    """
    ours = os.dup(1)
    os.dup2(2, 1)

    def say(message: Any) -> None:
        line = json.dumps(message).encode() + b"\n"
        with suppress(OSError):  # who started us is gone; the end of standard input says so too
            while line:
                line = line[os.write(ours, line) :]

    return say
