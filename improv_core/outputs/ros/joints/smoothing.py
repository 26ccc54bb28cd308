"""The points of a trajectory: where joints go next, smoothed, until they rest by themselves. It never reads a clock.
Standard library only.

A smoothed position is the mean of a joint's positions in the last `window` seconds. So it never passes where the joint
is sent, gets no faster, and arrives there. Its acceleration is at most the change of velocity in a window, divided by
the window. That is a moving average, or FIR filter, as in Biagiotti and Melchiorri, *Trajectory Planning for Automatic
Machines and Robots*, 2008, section 4.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, zip_longest
from typing import NamedTuple

SOONEST, FIRST = 0.02, 0.05
"""Seconds until the first point: at least, and if joints stand. A controller gets there from where it is, so a point
for the present would make a joint that lags jump."""
EXACT = 1e-6
"""Radians or meters that make no difference."""
BLEND = 0.1
"""Seconds in which a joint returns to its smoothed positions, whose acceleration has changed before the first point."""
CLOSEST = 0.001
"""Seconds between two points, at least. A controller passes several in a cycle, and keeps all their accelerations."""


class Stretch(NamedTuple):
    """A joint's position at a time, and its velocity from then until the next stretch."""

    since: float
    position: float
    velocity: float

    def at(self, time: float) -> float:
        return self.position + self.velocity * (time - self.since)


@dataclass(frozen=True, slots=True)
class Brake:
    """The way of a joint that brakes evenly from a velocity, and comes to `rest` after some seconds."""

    since: float
    rest: float
    velocity: float
    seconds: float

    @property
    def until(self) -> float:
        return self.since + self.seconds

    def at(self, time: float) -> tuple[float, float]:
        left = max(self.until - time, 0.0) / self.seconds
        return self.rest - self.velocity * self.seconds * left**2 / 2, self.velocity * left


class Blend(NamedTuple):
    """The way of a joint that leaves its smoothed positions: from a time on, it has a position, a velocity, and an
    acceleration until the first point. Then it comes `back` to them, with that acceleration more than theirs."""

    since: float = -math.inf
    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0
    back: float = 0.0


class TrajectoryPoint(NamedTuple):
    """Positions and velocities of a controller's joints, this many seconds from now."""

    seconds: float
    positions: list[float]
    velocities: list[float]


def points(
    ways: Sequence[Sequence[Stretch]],
    window: float,
    now: float,
    brakes: Sequence[Brake | None] = (),
    blends: Sequence[Blend] = (),
) -> Iterator[TrajectoryPoint]:
    """Yield the points of joints on these ways, each of which ends in a stretch without velocity. Those with a brake
    come to rest at the beginning of theirs.

    Between two points, accelerations are constant, and so are those of joint_trajectory_controller's cubic splines.
    """
    ends = [now + SOONEST, now + BLEND] if any(blend.back for blend in blends) else []
    *times, last = _spread(sorted([*_bends(ways, window, brakes), *ends]), now)
    for time in times:
        found = [
            brake.at(time) if brake and time < brake.until else blended(way, window, blend or Blend(), time)
            for way, brake, blend in zip_longest(ways, brakes, blends)
        ]
        yield TrajectoryPoint(time - now, [each for each, _ in found], [each for _, each in found])
    # Exactly at rest: controllers refuse a trajectory that ends in motion, even by rounding.
    yield TrajectoryPoint(last - now, [way[-1].position for way in ways], [0.0] * len(ways))


def blend_of(way: Sequence[Stretch], window: float, now: float, before: Blend) -> Blend:
    """Return the blend with which a joint's acceleration is constant until the first point.

    Without one, if its smoothed acceleration changes before that, a cubic to the point would exceed both.
    """
    position, velocity = blended(way, window, before, now)
    then, faster = smoothed(way, window, now + SOONEST)
    off = then - position - SOONEST * (velocity + faster) / 2
    if abs(off) < EXACT:
        return Blend()
    back = -2 * off / (BLEND * (BLEND - SOONEST))
    return Blend(now, position, velocity, (faster - back * (BLEND - SOONEST) - velocity) / SOONEST, back)


def blended(way: Sequence[Stretch], window: float, blend: Blend, time: float) -> tuple[float, float]:
    passed = time - blend.since
    if passed < SOONEST:
        velocity = blend.velocity + blend.acceleration * passed
        return blend.position + (blend.velocity + velocity) / 2 * passed, velocity
    (position, velocity), left = smoothed(way, window, time), max(BLEND - passed, 0.0)
    return position + blend.back * left**2 / 2, velocity - blend.back * left


def _bends(ways: Sequence[Sequence[Stretch]], window: float, brakes: Sequence[Brake | None]) -> list[float]:
    """Return the times at which the accelerations of joints on these ways change."""
    turns = {stretch.since for way in ways if len(way) > 1 for stretch in way}
    return [*turns, *(turn + window for turn in turns), *(brake.until for brake in brakes if brake)]


def _spread(bends: Sequence[float], now: float) -> list[float]:
    """Return the times of points: those of the bends ahead, of which the later ones count if some are too close."""
    last = max(bends[-1], now + SOONEST) if bends and bends[-1] > now else now + FIRST
    kept = [last]
    for time in reversed(bends):
        if now + SOONEST <= time <= kept[-1] - CLOSEST:
            kept.append(time)
    return kept[::-1]


def smoothed(way: Sequence[Stretch], window: float, time: float) -> tuple[float, float]:
    since, here = time - window, _at(way, time)
    if len(way) == 1:
        return here, 0.0
    ends = [since, *(each.since for each in way if since < each.since < time), time]
    spans = [(_at(way, begin) + _at(way, end)) / 2 * (end - begin) for begin, end in pairwise(ends)]
    return sum(spans) / window, (here - _at(way, since)) / window


def _at(way: Sequence[Stretch], time: float) -> float:
    """Return the position of a joint on its way, before whose beginning it stands."""
    stretch = next((each for each in reversed(way) if each.since <= time), None)
    return stretch.at(time) if stretch else way[0].position
