"""Where a movement stands within another, so that by itself it throws the same dice. Standard library only."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from improv_core.score.dice import ROBOTS, Chance, Choose, Seed, Shuffle, Throwing
from improv_core.score.movement import Movement, Parallel, Repeat, Series, parts
from improv_core.score.reactions import If


class Place(NamedTuple):
    """A throw of a stream, by the stream's name."""

    stream: str = ROBOTS
    throw: int = 0

    def inside(self, index: int) -> Place:
        """The beginning of the stream of part `index` of what this throw decides, as `Dice.inside` hashes it."""
        return Place(f"{self.stream}/{self.throw}.{index}")


def place_of(inner: Movement, whole: Movement, begin: Place) -> Place | None:
    """The throw with which `inner` begins where it first stands within `whole`, which itself begins at `begin`.

    None if it doesn't stand there, or if nothing in it throws dice.
    """
    waiting, seen = [(whole, begin)], set[int]()
    while waiting:
        part, place = waiting.pop()
        if part is inner:
            return place
        if part.dice and id(part) not in seen:
            seen.add(id(part))
            waiting += reversed(list(_inside(part, place)))
    return None


def _inside(part: Movement, place: Place) -> Iterator[tuple[Movement, Place]]:
    """The movements directly inside a movement with dice, each with the throw at which it begins."""
    if isinstance(part, Series):
        for item, throw in zip(part.items, part.first_throws, strict=True):
            yield item, Place(place.stream, place.throw + throw)
    elif isinstance(part, (Choose, Shuffle, Parallel, If)):
        yield from ((item, place.inside(index)) for index, item in enumerate(part.items))
    elif isinstance(part, Chance):
        yield part.body, place.inside(0)
    elif isinstance(part, Seed):
        yield part.body, Place(str(part.number))
    elif isinstance(part, Throwing):
        yield part.body, Place(part.stream, part.throw)
    elif isinstance(part, Repeat) and part.times is None:
        yield part.body, place.inside(0)
    else:
        yield from ((item, place) for item in parts(part))
