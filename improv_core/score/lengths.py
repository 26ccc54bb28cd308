"""How long an open movement may last: at least and at most. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import zip_longest

from improv_core.score.algebra import series
from improv_core.score.inner_first import inner_first
from improv_core.score.movement import ENDLESS, NORMAL, NOTHING_AROUND, Duration, Lengths, Movement, one_after_another


def lengths(movement: Movement, rate: Fraction = NORMAL) -> Lengths:
    """How long a movement may last at a rate. For a closed one, both lengths are the same, and exact.

    Standing still until a whole beat takes as long at any rate.
    """
    if not movement.open:
        return _closed(movement, rate)
    known: dict[tuple[int, Fraction], Lengths] = {}
    for part, at in inner_first((movement, rate), _open_inside, lambda each: (id(each[0]), each[1])):
        inner = _rate_inside(part, at)
        found = [known[id(each), inner] if each.open else _closed(each, inner) for each in part.parts]
        known[id(part), at] = part.lasts(found)
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


def _open_inside(at_rate: tuple[Movement, Fraction]) -> list[tuple[Movement, Fraction]]:
    """The open movements directly inside one that is played at a rate, with their own rates."""
    inner = _rate_inside(*at_rate)
    return [(each, inner) for each in at_rate[0].parts if each.open]


def _rate_inside(part: Movement, rate: Fraction) -> Fraction:
    own = part.within(NOTHING_AROUND).rate
    return rate if own is NORMAL else rate * own


def _closed(movement: Movement, rate: Fraction) -> Lengths:
    is_plain = rate is NORMAL or isinstance(movement.duration, float)
    lasts = movement.duration if is_plain else movement.duration / rate
    return Lengths(lasts, lasts, not lasts)


def _whole(beat: Duration) -> Duration:
    return beat if isinstance(beat, float) else math.ceil(beat)
