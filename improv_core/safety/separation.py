"""Which real robots are too near to each other, by their measured poses. It never reads a clock.

Lengths are in meters, times in seconds on the clock. Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Set
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from improv_core.protocol.output import RawPose
from improv_core.score.following import OLDEST

JITTER = 0.03
"""Meters by which the distance of two robots that stand may seem to change."""
PATIENCE = 2.0
"""Seconds in which two robots that begin too near to each other must have come farther apart, by more than jitter:
their poses are late, and they may have to turn first."""
MOST_NAMED = 3
"""How many pairs are named in a line."""


class Near(NamedTuple):
    """Two robots, and how far their edges are apart; less than 0 if they overlap."""

    robots: tuple[str, str]
    gap: float


class Since(NamedTuple):
    """How far two robots were apart at a time."""

    gap: float
    at: float


@dataclass(frozen=True, slots=True)
class Proximity:
    """The latest pose of each robot, and the pairs that were too near when they began to play and may move apart. These
    are None until robots play."""

    seen: Mapping[str, RawPose] = field(default_factory=dict)
    leaving: Mapping[tuple[str, str], Since] | None = None

    def heard(self, poses: Iterable[RawPose]) -> Proximity:
        """After these poses have come."""
        return replace(self, seen={**self.seen, **{raw.robot: raw for raw in poses}})

    def looked(
        self,
        playing: bool,
        radii: Mapping[str, float],
        keep_apart: float,
        now: float,
        ours: Set[str] | None = None,
    ) -> Looked:
        """Find the robots that are too near to each other now. `radii` are those of the robots that are guarded. Others
        look at pairs without any robot of `ours` (None: all are ours).

        Two that come too near are found at once. Two that are too near when they begin to play are found as soon as
        they come nearer, or if they don't move apart.
        """
        if not playing:
            return Looked(replace(self, leaving=None), [])
        fresh = {robot: radius for robot, radius in radii.items() if self.is_fresh(robot, now)}
        near = [
            each
            for each in _pairs(self.seen, fresh, keep_apart + JITTER)
            if ours is None or not ours.isdisjoint(each.robots)
        ]
        if self.leaving is None:
            begin = {each.robots: Since(each.gap, now) for each in near if each.gap < keep_apart}
            return Looked(replace(self, leaving=begin), [])
        leaving, found = {}, []
        for each in near:
            since = self.leaving.get(each.robots)
            if each.gap < keep_apart and not (since and _may_leave(since, each.gap, now)):
                found.append(each)
            elif since:
                leaving[each.robots] = Since(each.gap, now) if each.gap > since.gap + JITTER else since
        return Looked(replace(self, leaving=None if found else leaving), sorted(found, key=lambda each: each.gap))

    def is_fresh(self, robot: str, now: float) -> bool:
        """Whether it is known where a robot is."""
        raw = self.seen.get(robot)
        return raw is not None and now <= raw.at + OLDEST

    def fresh_until(self, robots: Collection[str]) -> float:
        """When it is no longer known where all of some robots are, if no more poses come."""
        return min(
            (self.seen[robot].at + OLDEST if robot in self.seen else -math.inf for robot in robots), default=math.inf
        )


class Looked(NamedTuple):
    """What is known after a look, and the pairs that are too near, the nearest first."""

    proximity: Proximity
    found: list[Near]


def as_line(found: Collection[Near], keep_apart: float) -> str:
    """Who is too near, for people."""
    each = [f"{one} and {other} are {max(gap, 0.0):.2f} m apart" for (one, other), gap in [*found][:MOST_NAMED]]
    more = f" (and {len(found) - MOST_NAMED} more pairs)" if len(found) > MOST_NAMED else ""
    return f"paused: {', '.join(each)}{more}, and `keep_apart` is {keep_apart:g} m: make room, then resume"


def _may_leave(since: Since, gap: float, now: float) -> bool:
    """Whether two robots that were too near since a time may move apart."""
    return since.gap - JITTER <= gap and (now < since.at + PATIENCE or gap > since.gap + JITTER)


def _pairs(seen: Mapping[str, RawPose], radii: Mapping[str, float], bound: float) -> Iterator[Near]:
    """The pairs of robots whose edges are nearer than a bound. Of each pair, the robot that is named first comes first.

    Robots are sorted into squares, so only neighbors are compared.
    """
    side = bound + 2 * max(radii.values(), default=0.0)
    squares: dict[tuple[int, int], list[str]] = {}
    for robot, radius in radii.items():
        pose = seen[robot].pose
        across, along = math.floor(pose.x / side), math.floor(pose.y / side)
        for square in ((across + i, along + j) for i in (-1, 0, 1) for j in (-1, 0, 1)):
            for other in squares.get(square, ()):
                gap = pose.apart(seen[other].pose)[0] - radius - radii[other]
                if gap < bound:
                    yield Near((other, robot), gap)
        squares.setdefault((across, along), []).append(robot)
