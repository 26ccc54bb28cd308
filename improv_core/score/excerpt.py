"""The position of a movement within another one, so that by itself it throws the same dice. Standard library only."""

from __future__ import annotations

from improv_core.score.movement import Movement
from improv_core.score.throws import StreamPosition


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
