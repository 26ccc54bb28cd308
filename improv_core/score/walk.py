"""The walk of a movement: its stretches of constant velocity, one by one, however often it repeats.

It may start at any beat and go backward. Everything before that beat is computed, not walked: that takes time in
proportion to the depth of the movement and to the items of the shuffles around that beat.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import partial
from typing import NamedTuple

from improv_core.score.algebra import Hold
from improv_core.score.movement import (
    ENDLESS,
    NORMAL,
    NOWHERE,
    Around,
    Exact,
    InTurn,
    Movement,
    Piece,
    Piecewise,
    Source,
    Through,
    Velocity,
    Visit,
    all_by,
)
from improv_core.score.ramps import Stepped
from improv_core.score.throws import ROBOTS, Dice, dice_of
from improv_core.slices import checkpoint


class Moment(NamedTuple):
    """A stretch of constant velocity: its start and duration in beats, and the words that play."""

    start: Exact
    duration: Exact
    velocity: Velocity
    sources: tuple[Source, ...]


def walk(
    movement: Movement,
    start: Exact = 0,
    *,
    merge: bool = False,
    evenly: bool = False,
    dice: Dice | None = None,
    statement: int = NOWHERE,
) -> Iterator[Moment]:
    """Yield the moments of a movement from beat `start` on, in order, without gaps. None is empty.

    With `merge`, a finite part of constant velocity is one moment, no matter how often it repeats, without sources.
    `evenly` walks what a ramp plays at one rate, if no voice plays beside it: the path and the time stay the same.
    `dice` are those at its beginning: by default, the first of the robots' stream. `statement` is the ID of the
    statement that it stands in. An open movement is walked as if no sense ever held. There are none after its end.
    """
    if start >= movement.duration:
        return
    if movement.dice and not dice:
        dice = dice_of(ROBOTS)
    for duration, velocity, sources in _pieces(Visit(movement, start, False, dice), merge, statement, evenly):
        yield Moment(start, duration, velocity, sources)
        start += duration


def _pieces(visit: Visit, merge: bool, statement: int, evenly: bool = False) -> Iterator[Piece]:
    """Yield pieces, with an explicit stack instead of recursion. Only pieces made of others' pieces recurse."""
    stack = [(iter((visit,)), Around(statement=statement))]
    while stack:
        checkpoint()
        visits, around = stack[-1]
        due = next(visits, None)
        if due is None:
            stack.pop()
            continue
        part, at, backward, dice = due
        while left := at if backward else part.duration - at:
            if isinstance(part, Hold) or (merge and part.uniform is not None and left != ENDLESS):
                assert part.uniform is not None
                assert not isinstance(left, float)
                sources = around.at(part.span) if isinstance(part, Hold) else around.sources
                yield *_at_rate(left, part.uniform.times(around.gain), around.rate), sources
            elif isinstance(part, InTurn):
                stack.append((part.visits(at, backward, dice), around))
            elif isinstance(part, Piecewise) and not (evenly and isinstance(part, Stepped)):
                inside = partial(_pieces, merge=merge, statement=around.statement)
                for beats, velocity, sources in part.pieces(at, backward, dice, inside):
                    yield *_at_rate(beats, velocity.times(around.gain), around.rate), around.sources + sources
            else:
                assert isinstance(part, Through)
                around = part.evenly(around) if isinstance(part, Stepped) else part.within(around)
                part, at, backward, dice = part.inner(at, backward, dice)
                continue
            break


def _at_rate(beats: Exact, velocity: Velocity, rate: Fraction) -> tuple[Exact, Velocity]:
    """Apply a rate. Most movements play at their normal rate, which needs no arithmetic."""
    return (beats, velocity) if rate is NORMAL else (beats / rate, velocity.times(all_by(rate)))
