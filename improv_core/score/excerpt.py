"""The position of a movement within another one, so that by itself it throws the same dice. Standard library only."""

from __future__ import annotations

from improv_core.score.movement import Movement
from improv_core.score.throws import StreamPosition
from improv_core.score.traversal import outer_first


def position_of(inner: Movement, whole: Movement, begin: StreamPosition) -> StreamPosition | None:
    """Return the throw with which `inner` begins at its first place in `whole`, which itself begins at `begin`.

    None if it isn't in there, or if nothing in it throws dice.
    """

    def inside(at: tuple[Movement, StreamPosition]) -> list[tuple[Movement, StreamPosition]]:
        part, place = at
        return [(each, part.throw_of(index, place)) for index, each in enumerate(part.parts)] if part.dice else []

    places = outer_first((whole, begin), inside, key=lambda at: id(at[0]))
    return next((place for part, place in places if part is inner), None)
