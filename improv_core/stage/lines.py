"""Messages on standard input to a process that also waits for other things. Standard library only."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from typing import Generic, Literal, TypedDict, TypeVar

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
