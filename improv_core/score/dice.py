"""Movements that dice decide: `choose`, `shuffle`, `chance`, and `seed`. Standard library only."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import accumulate

from improv_core.score import fields
from improv_core.score.algebra import hold, one_by_one, repeat, series
from improv_core.score.bounds import in_series, opened
from improv_core.score.movement import STILL, Bounds, Duration, InTurn, Movement, Several, Single, Through, Visit, makes
from improv_core.score.throws import ROBOTS, Dice, StreamPosition, T
from improv_core.score.traversal import outer_first
from improv_core.text import Span
from improv_core.values import value


@value(frozen=True, slots=True, eq=False)
class Choose(Several, Through):
    """A movement that plays one of its items."""

    NAME = "choose"

    def throw_of(self, index: int, throw: T) -> T:
        return throw.inside(index)

    def inner(self, at: Duration, backward: bool, dice: Dice | None) -> Visit:
        assert dice
        index = dice.choice(len(self.items))
        return Visit(self.items[index], at, backward, dice.inside(index))


@value(frozen=True, slots=True, eq=False)
class Shuffle(Several, InTurn):
    """A movement that plays all items, in an order that the dice give."""

    NAME = "shuffle"

    def throw_of(self, index: int, throw: T) -> T:
        return throw.inside(index)

    def visits(self, at: Duration, backward: bool, dice: Dice | None) -> Iterator[Visit]:
        assert dice
        order = dice.order(len(self.items))
        items = [self.items[index] for index in order]
        ends = list(accumulate(item.duration for item in items))
        return one_by_one(items, ends, at, backward, lambda place: dice.inside(order[place]))


@value(frozen=True, slots=True, eq=False)
class Chance(Single, Through):
    """A movement with a probability, or a rest as long."""

    probability: Fraction
    span: Span | None
    otherwise: Movement  # the rest

    NAME = "chance"
    FIELDS = (("probability", fields.FRACTION), ("span", fields.SPAN))

    def throw_of(self, index: int, throw: T) -> T:
        return throw.inside(0)

    def inner(self, at: Duration, backward: bool, dice: Dice | None) -> Visit:
        assert dice
        plays = self.body if dice.happens(self.probability) else self.otherwise
        return Visit(plays, at, backward, dice.inside(0))


@value(frozen=True, slots=True, eq=False)
class Seed(Single, Through):
    """A movement with its own dice."""

    number: Fraction

    NAME = "seed"
    FIELDS = (("number", fields.FRACTION),)

    def throw_of(self, index: int, throw: T) -> T:
        return throw.of(str(self.number))

    def inner(self, at: Duration, backward: bool, dice: Dice | None) -> Visit:
        return Visit(self.body, at, backward, dice and self.throw_of(0, dice))


@value(frozen=True, slots=True, eq=False)
class Throwing(Single, Through):
    """A line of a program: a movement that begins at this throw of a stream."""

    throw: int
    stream: str

    NAME = "throwing"
    FIELDS = (("throw", fields.COUNT), ("stream", fields.TEXT))

    def throw_of(self, index: int, throw: T) -> T:
        return throw.of(self.stream, self.throw)

    def inner(self, at: Duration, backward: bool, dice: Dice | None) -> Visit:
        return Visit(self.body, at, backward, dice and self.throw_of(0, dice))


@makes(Choose)
def choose(items: Sequence[Movement]) -> Movement:
    """Choose one of the items. Raises ValueError if they differ in length, or if senses decide the length of one."""
    lengths = {item.duration for item in items}
    if len(lengths) > 1 or any(item.open for item in items):
        raise ValueError("the items of a choice differ in length")
    return Choose(max(lengths, default=0), None, _any_of(items), tuple(items))


@makes(Shuffle)
def shuffle(items: Sequence[Movement]) -> Movement:
    """Return all items, in an order that the dice give."""
    bounds = _any_of(items)
    bounds = opened(bounds) if bounds.open else bounds
    return Shuffle(sum(item.duration for item in items), None, bounds, tuple(items))


@makes(Chance)
def chance(body: Movement, probability: Fraction, span: Span | None = None) -> Movement:
    """The movement with a probability from above 0 up to 1, or otherwise a rest as long, written at `span`.

    Raises ValueError if the probability is out of range, or if senses decide the length of the movement.
    """
    if not 0 < probability <= 1 or body.open:
        raise ValueError("a probability is above 0 and at most 1, of what has a fixed length")
    return Chance(body.duration, None, _any_of((body,)), body, probability, span, _rest(body, span))


def _rest(body: Movement, span: Span | None) -> Movement:
    if isinstance(body.duration, float):
        return repeat(hold(STILL, 1, span))
    return hold(STILL, body.duration, span) if body.duration else series(())


@makes(Seed)
def seed(body: Movement, number: Fraction) -> Movement:
    """Return the movement with its own dice, which the number selects. Raises ValueError if it is not above 0."""
    if number <= 0:
        raise ValueError("a seed is above 0")
    bounds = replace(body.bounds, dice=True, throws=0)
    return Seed(body.duration, body.uniform, bounds, body, number)


@makes(Throwing)
def throwing(body: Movement, throw: int, stream: str = ROBOTS) -> Movement:
    """Return a line of a program: a movement that begins at this throw of a stream."""
    if not body.bounds.dice:
        return body
    return Throwing(body.duration, body.uniform, body.bounds, body, throw, stream)


def _any_of(items: Sequence[Movement]) -> Bounds:
    """Return the bounds of a movement that one throw decides."""
    return replace(in_series(item.bounds for item in items), dice=True, throws=1)


def position_of(inner: Movement, whole: Movement, begin: StreamPosition) -> StreamPosition | None:
    """Return the throw with which `inner` begins at its first place in `whole`, which itself begins at `begin`.

    None if it isn't in there, or if nothing in it throws dice.
    """

    def inside(at: tuple[Movement, StreamPosition]) -> list[tuple[Movement, StreamPosition]]:
        part, place = at
        return [(each, part.throw_of(index, place)) for index, each in enumerate(part.parts)] if part.dice else []

    places = outer_first((whole, begin), inside, key=lambda at: id(at[0]))
    return next((place for part, place in places if part is inner), None)
