"""Movements that senses decide: `until`, `pause`, and `if`. Standard library only.

A movement with one of them in it is *open*: it is performed by a `performer.Performer`, which is told what is sensed.
Everything else (`duration`, `uniform`, the walk, paths) assumes that no sense ever holds.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from improv_core.score.dice import Dice
from improv_core.score.movement import Movement, Several, in_series, opened, parts, repeat, stand
from improv_core.text import Span


class Condition(NamedTuple):
    """A sense, and whether it has to hold, or `not`."""

    sense: str
    wanted: bool

    def holds(self, sensed: Callable[[str], bool | None]) -> bool:
        return sensed(self.sense) is self.wanted


@dataclass(frozen=True, slots=True, eq=False)
class Reaction(Several):
    """A word of senses, written at `span`. `assumed` is what is performed if no sense ever holds."""

    condition: Condition
    span: Span | None
    assumed: Movement

    @property
    def body(self) -> Movement:
        return self.items[0]

    def __str__(self) -> str:
        """`until near`, `pause not near`."""
        word = "if" if isinstance(self, If) else "until" if isinstance(self, Until) else "pause"
        return f"{word}{'' if self.condition.wanted else ' not'} {self.condition.sense}"

    def dice_assumed(self, dice: Dice | None) -> Dice | None:
        """The dice of what is performed if no sense ever holds."""
        return dice


@dataclass(frozen=True, slots=True, eq=False)
class Until(Reaction):
    pass


@dataclass(frozen=True, slots=True, eq=False)
class Pause(Reaction):
    pass


@dataclass(frozen=True, slots=True, eq=False)
class If(Reaction):
    """The first of two items is performed if the condition holds, else the second."""

    def side(self, holds: bool, dice: Dice | None) -> tuple[Movement, Dice | None]:
        """What is performed, and its dice."""
        return self.items[0 if holds else 1], dice and dice.inside(0 if holds else 1)

    def dice_assumed(self, dice: Dice | None) -> Dice | None:
        return self.side(not self.condition.wanted, dice)[1]


def until(body: Movement, condition: Condition, span: Span | None = None) -> Movement:
    """The movement, ended on the next whole beat once the condition holds, with the robot standing from then on."""
    assumed = body if condition.wanted else _first_beat(body)
    return Until(assumed.duration, None, opened(body.bounds), (body,), condition, span, assumed)


def pause(body: Movement, condition: Condition, span: Span | None = None) -> Movement:
    """The movement, interrupted for whole beats while the condition holds."""
    assumed = body if condition.wanted or not body.duration else STANDING
    return Pause(assumed.duration, None, opened(body.bounds), (body,), condition, span, assumed)


def if_else(body: Movement, otherwise: Movement, condition: Condition, span: Span | None = None) -> Movement:
    """One movement or the other: the condition decides when it begins."""
    bounds = opened(in_series((body.bounds, otherwise.bounds)))
    if bounds.dice:
        bounds = replace(bounds, throws=1)
    assumed = otherwise if condition.wanted else body
    return If(assumed.duration, None, bounds, (body, otherwise), condition, span, assumed)


def reactions(movement: Movement) -> Iterator[Reaction]:
    """The words of senses in a movement, each once."""
    seen, waiting = set(), [movement]
    while waiting:
        part = waiting.pop()
        if part.open and id(part) not in seen:
            seen.add(id(part))
            waiting += reversed(parts(part))
            if isinstance(part, Reaction):
                yield part


def senses_read(movement: Movement) -> frozenset[str]:
    """The senses that a movement may read."""
    return frozenset(each.condition.sense for each in reactions(movement))


STANDING = repeat(stand(1))
"""Standing still forever."""


def _first_beat(body: Movement) -> Movement:
    """What is left of a movement that ends as it begins: standing until the next whole beat, or its end if that is
    sooner."""
    return stand(1 if isinstance(body.duration, float) else min(1, body.duration))
