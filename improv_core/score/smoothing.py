"""Movements that are gentle to tall and heavy robots, stretch by stretch. Standard library only.

A stretch is the longest part of a movement that has one velocity. It gets the time law of `ease`, so it takes as long
and goes as far as before, on the same path.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import groupby

from improv_core.score import movement as algebra
from improv_core.score.inner_first import inner_first
from improv_core.score.movement import ENDLESS, STILL, Exact, Movement, Velocity, exact, series
from improv_core.score.ramps import FASTEST_EASE, Ramp, ease
from improv_core.score.reactions import Reaction
from improv_core.score.suppositions import remade

_ROOM = 10
"""How many more levels a movement may get around a stretch before it is too deep to be eased."""

Fits = Callable[[Velocity], bool]


def smoothed(whole: Movement, fits: Fits = lambda velocity: True) -> Movement:
    """The movement with its stretches eased.

    A stretch whose highest velocity does not fit somewhere stays as it is, and so do one that never ends, voices that
    change at different times, ramps, and what senses may interrupt. Takes time in proportion to the distinct parts.
    """
    order = list(inner_first(whole, _inside))
    fastest = _fastest(order)
    made: dict[int, Movement] = {}
    for part in order:
        rate = fastest[id(part)]
        if isinstance(part, algebra.Series) and _inside(part):
            made[id(part)] = series(_eased_items(part.items, made, rate, fits))
        elif inner := _inside(part):
            made[id(part)] = remade(part, [made[id(each)] for each in inner])
        else:
            made[id(part)] = _eased(part, rate, fits) if _stretch(part) else part
    return made[id(whole)]


def _eased_items(items: Sequence[Movement], made: dict[int, Movement], rate: Exact, fits: Fits) -> list[Movement]:
    """The items of a series. Neighbors with the same velocity are one stretch."""
    found: list[Movement] = []
    for velocity, run in groupby(items, _stretch):
        if velocity:
            found.append(_eased(series(list(run)), rate, fits))
        else:
            found += [made[id(each)] for each in run]
    return found


def _eased(part: Movement, rate: Exact, fits: Fits) -> Movement:
    """A stretch, eased if its highest velocity fits when it is played at this rate."""
    assert part.uniform is not None
    if not fits(part.uniform.times(algebra.all_by(exact(rate * FASTEST_EASE)))):
        return part
    found = ease(part)
    return found if found.depth + _ROOM < algebra.MOST_DEPTH and found.bits <= algebra.MOST_BITS else part


def _stretch(part: Movement) -> Velocity | None:
    """The velocity of a part that is a stretch, or a piece of one."""
    return None if part.uniform == STILL or part.duration in (0, ENDLESS) or part.open else part.uniform


def _inside(part: Movement) -> Sequence[Movement]:
    """The parts in which to look for stretches."""
    is_whole = part.uniform is not None or isinstance(part, (algebra.Parallel, Ramp, Reaction))
    return () if is_whole else algebra.parts(part)


def _fastest(order: Sequence[Movement]) -> dict[int, Exact]:
    """The highest rate at which each part is played, wherever it stands."""
    fastest: dict[int, Exact] = {id(order[-1]): 1}
    for part in reversed(order):
        rate: Exact = fastest[id(part)]
        if isinstance(part, algebra.Pace):
            rate = exact(rate * part.rate)
        elif isinstance(part, algebra.Gain):
            rate *= abs(Fraction(part.gain.x))  # all components of a gain have the same absolute value
        for each in _inside(part):
            fastest[id(each)] = max(rate, fastest.get(id(each), rate))
    return fastest
