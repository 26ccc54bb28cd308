"""Movements that are gentle to tall and heavy robots, stretch by stretch. Standard library only.

A stretch is the longest part of a movement that has one velocity. It gets the time law of `ease`, so it takes as long
and goes as far as before, on the same path.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import groupby

from improv_core.score.algebra import Series, series
from improv_core.score.movement import (
    ENDLESS,
    MAX_BITS,
    MAX_DEPTH,
    NOTHING_AROUND,
    STILL,
    Exact,
    Movement,
    Piecewise,
    Velocity,
    all_by,
    exact,
)
from improv_core.score.ramps import FASTEST_EASE, ease
from improv_core.score.reactions import Reaction
from improv_core.score.traversal import inner_first

_ROOM = 10
"""The number of levels that a movement may still get around a stretch before it is too deep to be eased."""

Fits = Callable[[Velocity], bool]


def smoothed(whole: Movement, fits: Fits = lambda velocity: True) -> Movement:
    """Return the movement with its stretches eased.

    A stretch whose highest velocity does not fit in one place stays as it is, and so do endless stretches, voices that
    change at different times, ramps, and movements that senses may interrupt. Takes time in proportion to distinct
    parts.
    """
    order = list(inner_first(whole, _inside))
    fastest = _fastest(order)
    made: dict[int, Movement] = {}
    for part in order:
        rate = fastest[id(part)]
        if isinstance(part, Series) and _inside(part):
            made[id(part)] = series(_eased_items(part.items, made, rate, fits))
        elif inner := _inside(part):
            made[id(part)] = part.made_of([made[id(each)] for each in inner])
        else:
            made[id(part)] = _eased(part, rate, fits) if _stretch(part) else part
    return made[id(whole)]


def _eased_items(items: Sequence[Movement], made: dict[int, Movement], rate: Exact, fits: Fits) -> list[Movement]:
    """Return the items of a series. Neighbors with the same velocity are one stretch."""
    found: list[Movement] = []
    for velocity, run in groupby(items, _stretch):
        if velocity:
            found.append(_eased(series(list(run)), rate, fits))
        else:
            found += [made[id(each)] for each in run]
    return found


def _eased(part: Movement, rate: Exact, fits: Fits) -> Movement:
    """Return a stretch, eased if its highest velocity fits when it is played at this rate."""
    assert part.uniform is not None
    if not fits(part.uniform.times(all_by(exact(rate * FASTEST_EASE)))):
        return part
    found = ease(part)
    return found if found.bounds.depth + _ROOM < MAX_DEPTH and found.bounds.bits <= MAX_BITS else part


def _stretch(part: Movement) -> Velocity | None:
    """Return the velocity of a part that is a stretch, or a piece of one."""
    return None if part.uniform == STILL or part.duration in (0, ENDLESS) or part.open else part.uniform


def _inside(part: Movement) -> Sequence[Movement]:
    """Return the parts in which to look for stretches."""
    is_whole = part.uniform is not None or isinstance(part, (Piecewise, Reaction))
    return () if is_whole else part.parts


def _fastest(order: Sequence[Movement]) -> dict[int, Exact]:
    """Return the highest rate at which each part plays, in any of its places."""
    fastest: dict[int, Exact] = {id(order[-1]): 1}
    for part in reversed(order):
        around = part.within(NOTHING_AROUND)
        rate = exact(fastest[id(part)] * around.rate * abs(Fraction(around.gain.x)))
        for each in _inside(part):
            fastest[id(each)] = max(rate, fastest.get(id(each), rate))
    return fastest
