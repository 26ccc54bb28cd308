"""Movements that senses decide: `until`, `pause`, and `if`. Standard library only.

A movement with one of them in it is *open*: a `performer.Performer` performs it, by the values of senses. Everything
else (`duration`, `uniform`, the walk, paths) assumes that no sense ever holds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeVar

from improv_core.score import fields
from improv_core.score.algebra import STANDING, stand
from improv_core.score.bounds import in_series, opened
from improv_core.score.movement import ENDLESS, Duration, Lengths, Movement, Several, Through, Visit
from improv_core.score.throws import Dice, T
from improv_core.score.traversal import outer_first
from improv_core.text import Span
from improv_core.values import value


class Condition(NamedTuple):
    """A sense, and whether it has to hold (`wanted`), or `not`."""

    sense: str
    wanted: bool

    def holds(self, sensed: Callable[[str], bool | None]) -> bool:
        return sensed(self.sense) is self.wanted


@value(frozen=True, slots=True, eq=False)
class Reaction(Several, Through):
    """A word of senses, written at `span`. `assumed` is performed if no sense ever holds."""

    condition: Condition
    span: Span | None
    assumed: Movement

    FIELDS = (("sense", fields.TEXT), ("wanted", fields.TRUTH), ("span", fields.SPAN))

    @property
    def body(self) -> Movement:
        return self.items[0]

    @property
    def sense(self) -> str:
        return self.condition.sense

    @property
    def wanted(self) -> bool:
        return self.condition.wanted

    def __str__(self) -> str:
        """Return its words, such as `until near` or `pause not near`."""
        return f"{self.NAME}{'' if self.wanted else ' not'} {self.sense}"

    def inner(self, at: Duration, backward: bool, dice: Dice | None) -> Visit:
        return Visit(self.assumed, at, backward, dice)


@value(frozen=True, slots=True, eq=False)
class Until(Reaction):
    """A movement that ends once the condition holds."""

    NAME = "until"

    def lasts(self, parts: Sequence[Lengths]) -> Lengths:
        (body,) = parts
        # In a movement that is open itself, the robot stands until the next whole beat, which is up to a beat later.
        return Lengths(0, body.longest + (1 if self.waits else 0), body.may_be_empty)

    @property
    def waits(self) -> bool:
        return self.body.open


@value(frozen=True, slots=True, eq=False)
class Pause(Reaction):
    """A movement that is interrupted while the condition holds."""

    NAME = "pause"

    def lasts(self, parts: Sequence[Lengths]) -> Lengths:
        (body,) = parts
        return body._replace(longest=ENDLESS if body.longest else 0)


@value(frozen=True, slots=True, eq=False)
class If(Reaction):
    """The first of two items if the condition holds, else the second."""

    NAME = "if"

    def throw_of(self, index: int, throw: T) -> T:
        return throw.inside(index)

    def side(self, holds: bool, dice: Dice | None) -> tuple[Movement, Dice | None]:
        """Return the side that is performed, and its dice."""
        index = 0 if holds else 1
        return self.items[index], dice and dice.inside(index)

    def inner(self, at: Duration, backward: bool, dice: Dice | None) -> Visit:
        _, dice = self.side(not self.wanted, dice)
        return Visit(self.assumed, at, backward, dice)

    def lasts(self, parts: Sequence[Lengths]) -> Lengths:
        return Lengths(
            min(each.shortest for each in parts),
            max(each.longest for each in parts),
            any(each.may_be_empty for each in parts),
        )


F = TypeVar("F", bound=Callable[..., Movement])


def _reacts(kind: type[Reaction]) -> Callable[[F], F]:
    """Mark the function that makes a kind of reaction, of its parts."""

    def marked(make: F) -> F:
        def of_parts(parts: Sequence[Movement], sense: str, wanted: bool, span: Span | None) -> Movement:
            return make(*parts, Condition(sense, wanted), span)

        kind.make = staticmethod(of_parts)
        return make

    return marked


@_reacts(Until)
def until(body: Movement, condition: Condition, span: Span | None = None) -> Movement:
    """End the movement on the next whole beat once the condition holds, with the robot standing from then on."""
    assumed = body if condition.wanted else _first_beat(body)
    return Until(assumed.duration, None, opened(body.bounds), (body,), condition, span, assumed)


@_reacts(Pause)
def pause(body: Movement, condition: Condition, span: Span | None = None) -> Movement:
    """Return the movement, interrupted for whole beats while the condition holds."""
    assumed = body if condition.wanted or not body.duration else STANDING
    return Pause(assumed.duration, None, opened(body.bounds), (body,), condition, span, assumed)


@_reacts(If)
def if_else(body: Movement, otherwise: Movement, condition: Condition, span: Span | None = None) -> Movement:
    """Return one movement or the other: the condition decides when it begins."""
    bounds = opened(in_series((body.bounds, otherwise.bounds)))
    if bounds.dice:
        bounds = replace(bounds, throws=1)
    assumed = otherwise if condition.wanted else body
    return If(assumed.duration, None, bounds, (body, otherwise), condition, span, assumed)


def reactions(movement: Movement) -> Iterator[Reaction]:
    """Return the words of senses in a movement, each once."""
    parts = outer_first(movement, lambda part: [each for each in part.parts if each.open])
    return (part for part in parts if isinstance(part, Reaction))


def senses_read(movement: Movement) -> frozenset[str]:
    return frozenset(each.condition.sense for each in reactions(movement))


def _first_beat(body: Movement) -> Movement:
    """Return the rest of a movement: it stands until the next whole beat, or its end if that is sooner."""
    return stand(1 if isinstance(body.duration, float) else min(1, body.duration))
