"""The position of a movement within another one, so that by itself it throws the same dice. Standard library only."""

from __future__ import annotations

from typing import NamedTuple

from improv_core.score.movement import Movement
from improv_core.score.throws import ROBOTS


class StreamPosition(NamedTuple):
    """A throw of a stream, by the stream's name."""

    stream: str = ROBOTS
    throw: int = 0

    def after(self, throws: int) -> StreamPosition:
        return StreamPosition(self.stream, self.throw + throws)

    def inside(self, index: int) -> StreamPosition:
        """Return the same position as `Dice.inside`, whose stream is a hash of this one's name."""
        return StreamPosition(f"{self.stream}/{self.throw}.{index}")

    def of(self, stream: str, throw: int = 0) -> StreamPosition:
        return StreamPosition(stream, throw)


def position_of(inner: Movement, whole: Movement, begin: StreamPosition) -> StreamPosition | None:
    """Return the throw with which `inner` begins at its first place in `whole`, which itself begins at `begin`.

    None if it isn't in there, or if nothing in it throws dice.
    """
    waiting, seen = [(whole, begin)], set[int]()
    while waiting:
        part, place = waiting.pop()
        if part is inner:
            return place
        if part.dice and id(part) not in seen:
            seen.add(id(part))
            waiting += reversed([(each, part.throw_of(index, place)) for index, each in enumerate(part.parts)])
    return None
