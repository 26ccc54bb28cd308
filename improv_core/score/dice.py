"""Dice: movements that are decided by throws. The same program is always the same dance. Standard library only.

A throw is a function of its stream and its key: the first 8 bytes of BLAKE2b (RFC 7693) of the text `stream:key`. So
any throw can be computed without those before it, and a movement can be walked from anywhere and backward.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from hashlib import blake2b
from typing import NamedTuple

from improv_core.score.movement import (
    STILL,
    Bounds,
    Movement,
    Repeat,
    Several,
    Single,
    hold,
    in_series,
    opened,
    repeat,
    series,
)
from improv_core.text import Span

SIDES = 64
"""A throw is a whole number below 2 to the power of this."""


class Dice(NamedTuple):
    """A place in a stream of throws. The stream is the hash of its name so far: names may get long, hashes don't."""

    stream: blake2b
    throw: int

    def after(self, throws: int) -> Dice:
        return Dice(self.stream, self.throw + throws) if throws else self

    def inside(self, index: int) -> Dice:
        """The beginning of the stream of part `index` of what this throw decides."""
        stream = self.stream.copy()
        stream.update(f"/{self.throw}.{index}".encode())
        return Dice(stream, 0)

    def choice(self, count: int) -> int:
        """Which of `count` items."""
        return self._thrown(f"{self.throw}") * count >> SIDES

    def order(self, count: int) -> list[int]:
        """In which order `count` items play: a Fisher-Yates shuffle, Knuth, The Art of Computer Programming, 3.4.2."""
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


def dice_of(stream: str, throw: int = 0) -> Dice:
    """The dice of a stream, at a throw."""
    return Dice(blake2b(stream.encode(), digest_size=SIDES // 8), throw)


ROBOTS = "0"
"""The stream from which robots throw."""


@dataclass(frozen=True, slots=True, eq=False)
class Choose(Several):
    pass


@dataclass(frozen=True, slots=True, eq=False)
class Shuffle(Several):
    pass


@dataclass(frozen=True, slots=True, eq=False)
class Chance(Single):
    probability: Fraction
    span: Span | None
    otherwise: Movement  # the rest


@dataclass(frozen=True, slots=True, eq=False)
class Seed(Single):
    number: Fraction


@dataclass(frozen=True, slots=True, eq=False)
class Throwing(Single):
    throw: int
    stream: str


def choose(items: Sequence[Movement]) -> Movement:
    """One of the items. Raises ValueError if they are not all of one length, or if senses decide the length of one."""
    lengths = {item.duration for item in items}
    if len(lengths) > 1 or any(item.open for item in items):
        raise ValueError("the items of a choice differ in length")
    return Choose(max(lengths, default=0), None, _any_of(items), tuple(items))


def shuffle(items: Sequence[Movement]) -> Movement:
    """All items, in an order that the dice give."""
    bounds = _any_of(items)
    bounds = opened(bounds) if bounds.open else bounds
    return Shuffle(sum(item.duration for item in items), None, bounds, tuple(items))


def chance(body: Movement, probability: Fraction, span: Span | None = None) -> Movement:
    """The movement, with a probability from above 0 up to 1, or a rest as long, which is written at `span`.

    Raises ValueError if the probability is another, or if senses decide how long the movement lasts.
    """
    if not 0 < probability <= 1 or body.open:
        raise ValueError("a probability is above 0 and at most 1, of what has a fixed length")
    return Chance(body.duration, None, _any_of((body,)), body, probability, span, _rest(body, span))


def _rest(body: Movement, span: Span | None) -> Movement:
    if isinstance(body.duration, float):
        return repeat(hold(STILL, 1, span))
    return hold(STILL, body.duration, span) if body.duration else series(())


def seed(body: Movement, number: Fraction) -> Movement:
    """The movement with dice of its own, which the number selects. Raises ValueError if it is not above 0."""
    if number <= 0:
        raise ValueError("a seed is above 0")
    bounds = replace(body.bounds, dice=True, throws=0)
    return Seed(body.duration, body.uniform, bounds, body, number)


def throwing(body: Movement, throw: int, stream: str = ROBOTS) -> Movement:
    """What a line plays: a movement that begins at this throw of a stream."""
    if not body.bounds.dice:
        return body
    return Throwing(body.duration, body.uniform, body.bounds, body, throw, stream)


def decided(part: Choose | Chance | Seed | Throwing, dice: Dice) -> tuple[Movement, Dice]:
    """What plays at this throw, and its own dice."""
    if isinstance(part, Choose):
        index = dice.choice(len(part.items))
        return part.items[index], dice.inside(index)
    if isinstance(part, Chance):
        return part.body if dice.happens(part.probability) else part.otherwise, dice.inside(0)
    if isinstance(part, Seed):
        return part.body, dice_of(str(part.number))
    return part.body, dice_of(part.stream, part.throw)


def in_order(part: Shuffle, dice: Dice) -> list[tuple[Movement, Dice]]:
    """The items of a shuffle in the order in which they play at this throw, each with its own dice."""
    return [(part.items[index], dice.inside(index)) for index in dice.order(len(part.items))]


def at_turn(part: Repeat, dice: Dice, turn: int) -> Dice:
    """The dice of one turn of a repeat. The turns of an endless one throw from a stream of their own."""
    return (dice.inside(0) if part.times is None else dice).after(turn * part.body.throws)


def _any_of(items: Sequence[Movement]) -> Bounds:
    """The bounds of what one throw decides."""
    return replace(in_series(item.bounds for item in items), dice=True, throws=1)
