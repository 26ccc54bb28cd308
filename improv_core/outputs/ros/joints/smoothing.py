"""The points of a trajectory: where joints go next, smoothed, until they rest by themselves. It never reads a clock.
Standard library only.

A smoothed position is the mean of a joint's positions in the last `window` seconds. So it never passes where the joint
is sent, gets no faster, and arrives there. Its acceleration is at most the change of velocity in a window, divided by
the window. That is a moving average, or FIR filter, as in Biagiotti and Melchiorri, *Trajectory Planning for Automatic
Machines and Robots*, 2008, section 4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

SOONEST, FIRST = 0.02, 0.05
"""Seconds until the first point: at least, and if joints stand. A controller gets there from where it is, so a point
for the present would make a joint that lags jump."""
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
        """Return its position and its velocity at a time."""
        left = max(self.until - time, 0.0) / self.seconds
        return self.rest - self.velocity * self.seconds * left**2 / 2, self.velocity * left


class TrajectoryPoint(NamedTuple):
    """Positions and velocities of a controller's joints, this many seconds from now."""

    seconds: float
    positions: list[float]
    velocities: list[float]


def points(
    ways: Sequence[Sequence[Stretch]], window: float, now: float, brakes: Sequence[Brake | None] = ()
) -> Iterator[TrajectoryPoint]:
    """Yield the points of joints on these ways, each of which ends in a stretch without velocity. Those with a brake
    come to rest at the beginning of theirs.

    Between two points, accelerations are constant, and so are those of joint_trajectory_controller's cubic splines.
    """
    *times, last = _spread(bends(ways, window, brakes), now)
    for time in times:
        found = [
            brake.at(time) if brake and time < brake.until else smoothed(way, window, time)
            for way, brake in zip(ways, brakes or [None] * len(ways), strict=True)
        ]
        yield TrajectoryPoint(time - now, [each for each, _ in found], [each for _, each in found])
    # Exactly at rest: controllers refuse a trajectory that ends in motion, even by rounding.
    yield TrajectoryPoint(last - now, [way[-1].position for way in ways], [0.0] * len(ways))


def bends(ways: Sequence[Sequence[Stretch]], window: float, brakes: Sequence[Brake | None] = ()) -> list[float]:
    """Return the times at which the accelerations of joints on these ways change."""
    turns = {stretch.since for way in ways if len(way) > 1 for stretch in way}
    return sorted([*turns, *(turn + window for turn in turns), *(brake.until for brake in brakes if brake)])


def _spread(bends: Sequence[float], now: float) -> list[float]:
    """Return the times of points: those of the bends ahead, of which the later ones count if some are too close."""
    last = max(bends[-1], now + SOONEST) if bends and bends[-1] > now else now + FIRST
    kept = [last]
    for time in reversed(bends):
        if now + SOONEST <= time <= kept[-1] - CLOSEST:
            kept.append(time)
    return kept[::-1]


def smoothed(way: Sequence[Stretch], window: float, time: float) -> tuple[float, float]:
    """Return the smoothed position and velocity of a joint at a time."""
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
