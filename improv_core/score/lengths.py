"""How long an open movement may last: at least and at most. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import zip_longest
from typing import NamedTuple

from improv_core.score.inner_first import inner_first
from improv_core.score.movement import ENDLESS, NORMAL, Duration, Movement, Pace, Parallel, Repeat, parts, series
from improv_core.score.reactions import If, Pause, Until


class Lengths(NamedTuple):
    """The shortest and the longest that a movement lasts, in beats.

    What senses cut short has no shortest length, so `shortest` is 0 then. Only if it `may_be_empty` can it take no time
    at all, as one side of an `if` may.
    """

    shortest: Duration
    longest: Duration
    may_be_empty: bool

    @property
    def is_fixed(self) -> bool:
        return self.shortest == self.longest


def lengths(movement: Movement, rate: Fraction = NORMAL) -> Lengths:
    """How long a movement may last at a rate. For a closed one, both lengths are the same, and exact.

    Standing still until a whole beat takes as long at any rate.
    """
    if not movement.open:
        return _closed(movement, rate)
    known: dict[tuple[int, Fraction], Lengths] = {}
    for part, at in inner_first((movement, rate), _open_inside, lambda each: (id(each[0]), each[1])):
        inner = _rate_inside(part, at)
        found = [known[id(each), inner] if each.open else _closed(each, inner) for each in parts(part)]
        known[id(part), at] = _of(part, found)
    return known[id(movement), rate]


def scene_lengths(parts: Sequence[Sequence[Movement]]) -> tuple[list[Lengths], list[Lengths]]:
    """The beats at which scenes begin, and those at which parts end: at the earliest and at the latest.

    For a scene that never begins, both are endless.
    """
    begin, begins = Lengths(0, 0, True), list[Lengths]()
    ends = [begin] * len(parts)
    for scene in zip_longest(*parts, fillvalue=series(())):
        begins.append(begin)
        if begin.shortest == ENDLESS:
            continue
        found = [lengths(movement) for movement in scene]
        after = [one_after_another((begin, each)) for each in found]
        for place, each in enumerate(found):
            if not each.may_be_empty:
                ends[place] = after[place]
            elif each.longest:
                ends[place] = ends[place]._replace(longest=after[place].longest)
        begin = Lengths(_whole(max(each.shortest for each in after)), _whole(max(each.longest for each in after)), True)
    return begins, ends


def one_after_another(items: Sequence[Lengths]) -> Lengths:
    """How long movements last in series."""
    return Lengths(
        sum(each.shortest for each in items),
        sum(each.longest for each in items),
        all(each.may_be_empty for each in items),
    )


def _open_inside(at_rate: tuple[Movement, Fraction]) -> list[tuple[Movement, Fraction]]:
    """The open movements directly inside one that is played at a rate, with their own rates."""
    inner = _rate_inside(*at_rate)
    return [(each, inner) for each in parts(at_rate[0]) if each.open]


def _rate_inside(part: Movement, rate: Fraction) -> Fraction:
    return rate * part.rate if isinstance(part, Pace) else rate


def _closed(movement: Movement, rate: Fraction) -> Lengths:
    is_plain = rate is NORMAL or isinstance(movement.duration, float)
    lasts = movement.duration if is_plain else movement.duration / rate
    return Lengths(lasts, lasts, not lasts)


def _whole(beat: Duration) -> Duration:
    return beat if isinstance(beat, float) else math.ceil(beat)


def _of(part: Movement, items: Sequence[Lengths]) -> Lengths:
    """How long an open movement lasts, of which the parts last so long."""
    body = items[0]
    if isinstance(part, Until):
        # In a movement that is open itself, the robot stands until the next whole beat, which is up to a beat later.
        return Lengths(0, body.longest + (1 if part.body.open else 0), body.may_be_empty)
    if isinstance(part, Pause):
        return body._replace(longest=ENDLESS if body.longest else 0)
    if isinstance(part, If):
        return Lengths(
            min(each.shortest for each in items),
            max(each.longest for each in items),
            any(each.may_be_empty for each in items),
        )
    if isinstance(part, Repeat):
        if part.times is None:
            return Lengths(ENDLESS, ENDLESS, False)
        longest = body.longest * part.times if part.times else 0
        return Lengths(body.shortest * part.times if part.times else 0, longest, body.may_be_empty or not longest)
    if isinstance(part, Parallel):
        ending = [each.longest for each in items if not each.may_be_empty]
        return Lengths(
            min(each.shortest for each in items),
            min(ending) if ending else max(each.longest for each in items),
            not ending,
        )
    return one_after_another(items)
