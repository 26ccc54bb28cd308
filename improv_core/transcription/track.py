"""Timed poses of one robot, and how noisy they are. Standard library only."""

from __future__ import annotations

import cmath
import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from itertools import pairwise
from statistics import median_low
from typing import NamedTuple, TypeAlias

from improv_core.score.motion import Pose

CLEAN = 1e-5
"""Meters and radians: no track is taken to be more exact than this, since files round their numbers."""
_STILL = 1e-3
"""Meters: a shorter way says nothing about where a robot looks."""
_BACKWARD = math.radians(120)
"""A path that turns by more than this at one point goes backward: no robot turns around between two poses."""
_SPARSE = 0.4
"""Seconds: places that are usually further apart are waypoints, if they have no headings."""
_TURNING = 0.25
"""The share of the time to a waypoint in which a robot turns to it."""
_BEND = math.radians(5)
"""A robot doesn't stop to turn by less."""
_RATE = 20.0
"""Samples per second between waypoints."""
_CALM_SHARE = 0.1
"""Noise is judged by this share of the calmest moments, since velocities really change in the others."""


class Sample(NamedTuple):
    """A robot's pose at a time in seconds. Meters; the heading in radians, which never jumps by a turn."""

    time: float
    x: float
    y: float
    z: float
    heading: float

    @property
    def pose(self) -> Pose:
        return Pose(self.x, self.y, self.z, self.heading)


Track: TypeAlias = Sequence[Sample]


class TimedPlace(NamedTuple):
    """A row of a recording. `heading` is in radians; None if the recording doesn't have it."""

    time: float
    x: float
    y: float
    z: float = 0.0
    heading: float | None = None


class Noise(NamedTuple):
    """The standard deviation of a track's poses, in meters along each axis and in radians."""

    meters: float
    radians: float


def track_of(places: Sequence[TimedPlace]) -> Track:
    """Return the track of places in the order of their times, of which no two are equal.

    Without headings, the robot looks along its path, and goes backward where the path turns back on itself.
    """
    headings = [place.heading for place in places]
    are_waypoints = None in headings and (
        median_low(after.time - here.time for here, after in pairwise(places)) > _SPARSE
    )
    if are_waypoints:
        places = list(_turning(places))
        looked = _along(places, False)
    elif None in headings:
        looked = _along(places)
    else:
        looked = _continuous([heading or 0.0 for heading in headings])
    samples = [Sample(*place[:4], heading) for place, heading in zip(places, looked, strict=True)]
    return interpolated(samples) if are_waypoints else samples


def interpolated(nodes: Sequence[Sample]) -> list[Sample]:
    """Return samples at an even rate, interpolated between poses."""
    begin, seconds = nodes[0].time, nodes[-1].time - nodes[0].time
    count = max(round(seconds * _RATE), 1)
    found = []
    for number in range(count + 1):
        time = begin + seconds * number / count
        place = min(bisect_right(nodes, time, key=lambda each: each.time), len(nodes) - 1)
        one, other = nodes[place - 1 : place + 1]
        share = (time - one.time) / (other.time - one.time)
        found.append(Sample(time, *(a + (b - a) * share for a, b in zip(one[1:], other[1:], strict=True))))
    return found


def _turning(places: Sequence[TimedPlace]) -> Iterator[TimedPlace]:
    """Yield waypoints, and those again where a robot turns before it drives to the next one."""
    for place, before, after in zip(places, [places[0], *places], [*places[1:], places[-1]], strict=False):
        yield place
        ways = [complex(b.x - a.x, b.y - a.y) for a, b in ((before, place), (place, after))]
        if min(map(abs, ways)) >= _STILL and abs(cmath.phase(ways[1] / ways[0])) > _BEND:
            yield place._replace(time=place.time + _TURNING * (after.time - place.time))


def _continuous(headings: Sequence[float]) -> list[float]:
    found = list(headings[:1])
    for heading in headings[1:]:
        found.append(found[-1] + math.remainder(heading - found[-1], math.tau))
    return found


def _along(places: Sequence[TimedPlace], goes_back: bool = True) -> list[float]:
    """Return headings along the path: at each place, the mean of the ways to it and from it, or one of them if the
    robot waits there. Where the path turns back on itself, it turns around, too, unless it `goes_back`."""
    ways: list[float | None] = []
    last, backward = None, 0.0
    for one, other in pairwise(places):
        way = None
        if math.hypot(other.x - one.x, other.y - one.y) >= _STILL:
            way = math.atan2(other.y - one.y, other.x - one.x) + backward
            if goes_back and last is not None and abs(math.remainder(way - last, math.tau)) > _BACKWARD:
                backward, way = math.pi - backward, way + math.pi
            last = way
        ways.append(way)
    first = next((way for way in ways if way is not None), 0.0)
    found, now = [], first
    for before, after in zip([None, *ways], [*ways, None], strict=True):
        if before is not None and after is not None:
            now = before + math.remainder(after - before, math.tau) / 2
        else:
            now = after if after is not None else before if before is not None else now
        found.append(now)
    return _continuous(found)


def noise_of(track: Track) -> Noise:
    """Estimate the noise of a track from how badly each motion between two poses predicts the next pose."""
    meters, radians = [], []
    for before, here, after in zip(track, track[1:], track[2:], strict=False):
        share = (after.time - here.time) / (here.time - before.time)
        turn = (here.heading - before.heading) * share
        moved = complex(here.x - before.x, here.y - before.y) * share
        middle = (here.heading - before.heading + turn) / 2  # an arc's chord turns by half of both turns
        turned = complex(math.cos(middle), math.sin(middle))
        missed = complex(after.x - here.x, after.y - here.y) - moved * turned
        meters.append(abs(missed))
        radians.append(abs(after.heading - here.heading - turn))
    if not meters:
        return Noise(CLEAN, CLEAN)
    place = int(len(meters) * _CALM_SHARE)
    # A second difference of noise has √6 times its deviation. Of lengths in the plane, the calmest tenth are below
    # 0.459 deviations (Rayleigh), and of amounts along a line, below 0.126 (normal).
    return Noise(
        max(sorted(meters)[place] / (math.sqrt(6) * 0.459), CLEAN),
        max(sorted(radians)[place] / (math.sqrt(6) * 0.126), CLEAN),
    )
