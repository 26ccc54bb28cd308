"""The moments at which two discs, or a disc and an obstacle, come near each other. Standard library only.

The search uses conservative advancement: at any moment, the speed at which two approach and the curvature of their
paths bound the distance from below, so nothing can happen before some later moment. It jumps there, and so on (Mirtich,
Impulse-based Dynamic Simulation of Rigid Body Systems, 1996). Distances are in meters, times in beats.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias

from improv_core.score.budget import Budget
from improv_core.score.trajectories import Beat, Segment, moving_at

TOLERANCE = 0.001
"""Meters by which two must be nearer than allowed, so that neighbors who touch don't meet."""
_FINEST = 1e-5
"""The shortest jump, in beats."""
_COARSEST_LEAVING = 1 / 256
"""The shortest jump, in beats, while two are too near: the moment at which they part needn't be exact."""
_HALVINGS = 20
"""The number of halvings that narrow down the moment at which two are nearest."""

Convex: TypeAlias = Callable[[float, float], tuple[float, float, float]]
"""The distance of a point from a convex shape, in meters, and the direction toward it, of length 1."""


class Bound(NamedTuple):
    """The least distance between two centers in meters, seen from above, unless they are farther apart in height."""

    near: float
    height: float


@dataclass(slots=True)
class Encounters:
    """The beats at which two begin to be too near, their least distance the first time, and their state now."""

    beats: list[float] = field(default_factory=list)
    least: float = math.inf
    together: bool = False
    until: float | None = None
    """The beat up to which they were followed last. In gaps before it, they were far apart."""
    rests: int = 1
    """The beats from which on a rest of one of them may keep them apart: shorter ones were tried out."""


def follow(one: Beat, other: Beat, begin: float, bound: Bound, found: Encounters, work: Budget) -> None:
    """Add the encounters of two robots within a beat."""
    if found.until != begin:
        found.together = False
    found.until = begin + 1
    first, second = one.segments, other.segments
    i = j = 0
    now, end = float(begin), begin + 1.0
    while now < end:
        mine, others = first[i], second[j]
        until = min(mine.end, others.end, end)
        if until > now:
            _follow_segments(mine, others, now, until, bound, found, work)
            now = until
        i += mine.end <= now
        j += others.end <= now


def touches(beat: Beat, begin: float, near: float, obstacle: Convex, work: Budget) -> float | None:
    """Return the first beat, within one beat, at which a robot's center is nearer to an obstacle than allowed."""
    for segment in beat.segments:
        now, end = max(float(begin), segment.start), min(begin + 1.0, segment.end)
        speed = math.hypot(segment.along_x, segment.along_y)
        while now < end:
            work.spend()
            x, y, along_x, along_y = moving_at(segment, now)
            far, toward_x, toward_y = obstacle(x, y)
            gap = far - near + TOLERANCE
            if gap < 0:
                return now
            now += jump(gap, along_x * toward_x + along_y * toward_y, speed, speed * abs(segment.turn))
    return None


def sinks(beat: Beat, begin: float) -> float | None:
    """Return the first beat, within one beat, at which a robot on the ground keeps going down."""
    for segment in beat.segments:
        now, end = max(float(begin), segment.start), min(begin + 1.0, segment.end)
        if segment.along_z < 0 and segment.z + segment.along_z * (end - segment.start) < -TOLERANCE:
            return max(now, segment.start - segment.z / segment.along_z)
    return None


def _follow_segments(
    one: Segment, other: Segment, begin: float, end: float, bound: Bound, found: Encounters, work: Budget
) -> None:
    climbing = other.along_z - one.along_z
    above = (other.z + other.along_z * (begin - other.start)) - (one.z + one.along_z * (begin - one.start))
    enter, leave = begin, end
    if climbing:
        middle, half = begin - above / climbing, abs(bound.height / climbing)
        enter, leave = max(begin, middle - half), min(end, middle + half)
    elif abs(above) > bound.height:
        leave = begin
    if enter > begin:
        found.together = False
    if enter < leave:
        _follow_level(one, other, enter, leave, bound.near - TOLERANCE, found, work)
    if leave < end:
        found.together = False


def _follow_level(
    one: Segment, other: Segment, now: float, end: float, near: float, found: Encounters, work: Budget
) -> None:
    """Add the encounters of two robots while neither is above the other."""
    speeds = math.hypot(one.along_x, one.along_y), math.hypot(other.along_x, other.along_y)
    speed, bend = sum(speeds), speeds[0] * abs(one.turn) + speeds[1] * abs(other.turn)
    in_step = one.turn == other.turn
    while now < end:
        work.spend()
        x, y, along_x, along_y = relative(one, other, now)
        far = math.hypot(x, y)
        if in_step:  # then the velocity between them only turns
            speed = math.hypot(along_x, along_y)
            bend = speed * abs(one.turn)
        if far < near and not found.together:
            found.together = True
            found.beats.append(now)
        elif far >= near + TOLERANCE / 2:
            found.together = False
        if not found.together:
            now += jump(max(far - near, 0.0), -(x * along_x + y * along_y) / (far or 1.0), speed, bend)
            continue
        after = now + max((near + TOLERANCE / 2 - far) / speed, _COARSEST_LEAVING) if speed else end
        if len(found.beats) == 1:
            found.least = min(found.least, far)
            if x * along_x + y * along_y < 0:  # they still come nearer
                found.least = min(found.least, _nearest(one, other, now, min(after, end), work))
        now = after


def jump(gap: float, closing: float, speed: float, bend: float) -> float:
    """Return the beats for which two can't come nearer by more than a gap.

    They approach at `closing` now, at `speed` at most, and that changes by `bend` per beat at most.
    """
    root = math.sqrt(closing * closing + 2 * bend * gap)
    if closing > 0:
        soonest = 2 * gap / (closing + root)
    elif bend:
        soonest = (root - closing) / bend
    else:
        return math.inf
    return max(soonest, gap / speed, _FINEST)


def _nearest(one: Segment, other: Segment, begin: float, end: float, work: Budget) -> float:
    """Return the least distance between two moments. From the first one on, they come nearer."""
    x, y, along_x, along_y = relative(one, other, end)
    if x * along_x + y * along_y <= 0:
        return math.hypot(x, y)
    work.spend(_HALVINGS)
    for _ in range(_HALVINGS):
        middle = (begin + end) / 2
        x, y, along_x, along_y = relative(one, other, middle)
        if x * along_x + y * along_y < 0:
            begin = middle
        else:
            end = middle
    x, y, _, _ = relative(one, other, begin)
    return math.hypot(x, y)


def relative(one: Segment, other: Segment, beat: float) -> tuple[float, float, float, float]:
    """Return the position of another robot, seen from one, and its velocity seen from there."""
    x0, y0, along_x0, along_y0 = moving_at(one, beat)
    x1, y1, along_x1, along_y1 = moving_at(other, beat)
    return x1 - x0, y1 - y0, along_x1 - along_x0, along_y1 - along_y0
