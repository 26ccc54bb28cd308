"""The lines that a process of ours reads and writes; `child.py` is the other side. Standard library only."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from typing import Any, Generic, Literal, TypedDict, TypeVar

Message = TypeVar("Message")


class Alive(TypedDict):
    """The process that sends it lives."""

    type: Literal["alive"]


class Lines(Generic[Message]):
    """Messages on standard input: a JSON line each. Reading never waits."""

    def __init__(self) -> None:
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
    """Make standard output ours alone, and return what writes a message there, which raises OSError if nobody reads.

    What anything else prints from now on goes to standard error: the text of a library would tear our lines.
    """
    ours = os.dup(1)
    os.dup2(2, 1)

    def say(message: Any) -> None:
        line = json.dumps(message).encode() + b"\n"
        while line:
            line = line[os.write(ours, line) :]

    return say
