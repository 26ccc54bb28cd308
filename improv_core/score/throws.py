"""Throws of dice: the same program is always the same dance. Standard library only.

A throw is a function of its stream and its key: the first 8 bytes of BLAKE2b (RFC 7693) of the text `stream:key`. So
any throw can be computed without those before it, and a movement can be walked from anywhere and backward.
"""

from __future__ import annotations

from fractions import Fraction
from hashlib import blake2b
from typing import NamedTuple, TypeVar

SIDES = 64
"""The number of bits of a throw: it is a whole number below 2 to the power of this."""
ROBOTS = "0"
"""The stream from which robots throw."""


class Dice(NamedTuple):
    """A throw. The stream is the hash of its name so far: names may get long, hashes don't."""

    stream: blake2b
    throw: int

    def after(self, throws: int) -> Dice:
        """Return the throw this many throws later in the same stream."""
        return Dice(self.stream, self.throw + throws) if throws else self

    def inside(self, index: int) -> Dice:
        """Return the beginning of the stream of part `index` of a movement that this throw decides."""
        stream = self.stream.copy()
        stream.update(f"/{self.throw}.{index}".encode())
        return Dice(stream, 0)

    def of(self, stream: str, throw: int = 0) -> Dice:
        """Return a throw of the stream with this name."""
        return dice_of(stream, throw)

    def choice(self, count: int) -> int:
        """Return the index of one of `count` items."""
        return self._thrown(f"{self.throw}") * count >> SIDES

    def order(self, count: int) -> list[int]:
        """The order in which `count` items play: a Fisher-Yates shuffle, Knuth, The Art of Computer Programming,
        3.4.2."""
        order = list(range(count))
        for last in range(count - 1, 0, -1):
            other = self._thrown(f"{self.throw}.{last}") * (last + 1) >> SIDES
            order[last], order[other] = order[other], order[last]
        return order

    def happens(self, probability: Fraction) -> bool:
        return self._thrown(f"{self.throw}") * probability.denominator < probability.numerator << SIDES

    def _thrown(self, key: str) -> int:
        thrown = self.stream.copy()
        thrown.update(f":{key}".encode())
        return int.from_bytes(thrown.digest(), "big")


class StreamPosition(NamedTuple):
    """A throw of a stream, by the stream's name, with the methods of `Dice`."""

    stream: str = ROBOTS
    throw: int = 0

    def after(self, throws: int) -> StreamPosition:
        return StreamPosition(self.stream, self.throw + throws)

    def inside(self, index: int) -> StreamPosition:
        return StreamPosition(f"{self.stream}/{self.throw}.{index}")

    def of(self, stream: str, throw: int = 0) -> StreamPosition:
        return StreamPosition(stream, throw)


def dice_of(stream: str, throw: int = 0) -> Dice:
    """Return the dice of a stream, at a throw."""
    return Dice(blake2b(stream.encode(), digest_size=SIDES // 8), throw)


T = TypeVar("T", Dice, StreamPosition)
