"""The lengths of an open movement: at least and at most. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import zip_longest

from improv_core.score.algebra import series
from improv_core.score.movement import ENDLESS, NORMAL, NOTHING_AROUND, Duration, Lengths, Movement, one_after_another
from improv_core.score.traversal import inner_first


def lengths(movement: Movement, rate: Fraction = NORMAL) -> Lengths:
    """Return the lengths of a movement at a rate. For a closed one, both are the same, and exact.

    Standing still until a whole beat takes as long at any rate.
    """
    if not movement.open:
        return _closed(movement, rate)
    known = movement.known.lengths
    if rate not in known:
        for part, at in inner_first((movement, rate), _unknown_inside, lambda each: (id(each[0]), each[1])):
            part.known.lengths[at] = _lengths(part, at)
    return known[rate]


def _lengths(part: Movement, rate: Fraction) -> Lengths:
    """Return the lengths of an open movement, once those of all movements in `_unknown_inside` are known."""
    known = part.known
    if rate != NORMAL and known.scale:
        shortest, longest, may_be_empty = known.lengths[NORMAL]
        return Lengths(_at(shortest, rate), _at(longest, rate), may_be_empty)
    inner = _rate_inside(part, rate)
    known.scale = not part.waits and all(each.known.scale for each in part.parts if each.open)
    return part.lasts([each.known.lengths[inner] if each.open else _closed(each, inner) for each in part.parts])


def scene_lengths(parts: Sequence[Sequence[Movement]]) -> tuple[list[Lengths], list[Lengths]]:
    """Return the beats at which scenes begin, and those at which parts end: at the earliest and at the latest.

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


def _unknown_inside(at_rate: tuple[Movement, Fraction]) -> list[tuple[Movement, Fraction]]:
    """Return the open movements directly inside one that is played at a rate, with their own rates, if their lengths
    aren't known yet: in a chain of definitions, that is at most the one before.

    The length at the normal rate comes first: the lengths at nearly all other rates follow from it.
    """
    part, rate = at_rate
    if rate != NORMAL:
        if NORMAL not in part.known.lengths:
            return [(part, NORMAL)]
        if part.known.scale:
            return []
    inner = _rate_inside(part, rate)
    return [(each, inner) for each in part.parts if each.open and inner not in each.known.lengths]


def _rate_inside(part: Movement, rate: Fraction) -> Fraction:
    own = part.within(NOTHING_AROUND).rate
    return rate if own is NORMAL else rate * own


def _closed(movement: Movement, rate: Fraction) -> Lengths:
    lasts = _at(movement.duration, rate)
    return Lengths(lasts, lasts, not lasts)


def _at(duration: Duration, rate: Fraction) -> Duration:
    return duration if rate is NORMAL or isinstance(duration, float) else duration / rate


def _whole(beat: Duration) -> Duration:
    return beat if isinstance(beat, float) else math.ceil(beat)
