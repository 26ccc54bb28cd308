"""Finds real robots that come too near to each other, from their measured poses and the velocities they were sent.

It never reads a clock. Lengths are in meters, times in seconds on the clock. Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Set
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from improv_core.protocol.output import RawPose
from improv_core.safety.stopping_distance import JITTER, Approach, Base, Track
from improv_core.score.following import OLDEST
from improv_core.score.motion import Pose, Twist

PATIENCE = 2.0
"""Seconds within which two robots that begin too near to each other must have moved apart, by more than jitter: their
poses are late, and they may have to turn first."""
LOOK_PERIOD = 0.02
"""The fewest seconds between checks of robots of which no pose has come."""
MAX_NAMED = 3
"""The most pairs that a line names."""


class Near(NamedTuple):
    """Two robots, the distance between their edges (less than 0 if they overlap), and the speed in m/s at which they
    may approach each other, if that is why they are too near."""

    robots: tuple[str, str]
    gap: float
    approach: float = 0.0


class Since(NamedTuple):
    """The distance between two robots at a time."""

    gap: float
    at: float


@dataclass(frozen=True, slots=True)
class Proximity:
    """The facts about each robot, and the pairs that were too near when they began to play and may move apart. The
    pairs are None until robots play."""

    tracks: Mapping[str, Track] = field(default_factory=dict)
    leaving: Mapping[tuple[str, str], Since] | None = None

    def heard(self, poses: Iterable[RawPose], bases: Mapping[str, Base]) -> Proximity:
        """Return the known tracks after these poses have come."""
        tracks = {**self.tracks}
        for raw in poses:
            base = bases.get(raw.robot)
            tracks[raw.robot] = tracks.get(raw.robot, Track()).heard(raw, base.max_speed if base else None)
        return replace(self, tracks=tracks)

    def sent(self, robot: str, twist: Twist, at: float) -> Proximity:
        """Return the known tracks after a robot was sent this velocity."""
        before = self.tracks.get(robot, Track())
        track = before.after(twist, at)
        return self if track is before else replace(self, tracks={**self.tracks, robot: track})

    def looked(
        self, playing: bool, bases: Mapping[str, Base], keep_apart: float, now: float, ours: Set[str] | None = None
    ) -> Looked:
        """Find the robots that are too near to each other now, or would be before they stood if all were sent zeros
        now.

        `bases` are the robots to guard. Pairs without any robot of `ours` are left to other stages (None: all robots
        are ours). Two robots that come too near are found at once. Two robots that are too near when they begin to play
        are found as soon as they come nearer, or if they don't move apart.
        """
        if not playing:
            return Looked(replace(self, leaving=None), [], math.inf)
        fresh = {robot: base for robot, base in bases.items() if self.is_guarded(robot, base, now)}
        leaving, found, due = dict[tuple[str, str], Since](), list[Near](), math.inf
        for robots, gap, most in self._pairs(fresh, keep_apart + JITTER, now):
            if ours is not None and ours.isdisjoint(robots):
                continue
            since = self.leaving.get(robots) if self.leaving is not None else None
            if self.leaving is None and gap < keep_apart:
                since = Since(gap, now)
            least = since.gap - JITTER if since else keep_apart
            reach = most if gap - most.far >= least else self._reach(robots, fresh, now)
            rest = gap - reach.far
            if rest < keep_apart and not (since and _may_leave(since, gap, rest, now)):
                found.append(Near(robots, gap, reach.grows if gap >= keep_apart else 0.0))
                continue
            if since and gap < keep_apart + JITTER:
                leaving[robots] = Since(gap, now) if gap > since.gap + JITTER else since
            if reach.grows:
                at = now + max((rest - least) / reach.grows, LOOK_PERIOD)
                counts = all(self.is_guarded(robot, fresh[robot], at) for robot in robots)
                due = min(due, at if counts else math.inf)
        found.sort(key=lambda each: each.gap)
        return Looked(replace(self, leaving=None if found else leaving), found, due)

    def pose(self, robot: str) -> Pose:
        return self.tracks[robot].poses[-1].pose

    def is_fresh(self, robot: str, now: float) -> bool:
        return now <= self._latest(robot) + OLDEST

    def is_guarded(self, robot: str, base: Base, now: float) -> bool:
        """Return whether a robot's pose is recent enough to keep others apart from it."""
        return now <= self._latest(robot) + base.oldest

    def seen_until(self, robots: Collection[str]) -> float:
        """Return the time until which each of these robots counts as seen, if no more poses come. A pose that doesn't
        count yet is a sign of life, too."""
        tracks = [self.tracks.get(robot, Track()) for robot in robots]
        return min((track.heard_at + OLDEST for track in tracks), default=math.inf)

    def _latest(self, robot: str) -> float:
        poses = self.tracks.get(robot, Track()).poses
        return poses[-1].at if poses else -math.inf

    def _reach(self, robots: tuple[str, str], bases: Mapping[str, Base], now: float) -> Approach:
        """Return the distance by which two robots may still approach each other, together."""
        one, other = robots
        return _together(
            self.tracks[one].reach(bases[one], self.pose(other), now),
            self.tracks[other].reach(bases[other], self.pose(one), now),
        )

    def _pairs(
        self, bases: Mapping[str, Base], bound: float, now: float
    ) -> Iterator[tuple[tuple[str, str], float, Approach]]:
        """Yield the pairs of robots whose edges may come nearer than a bound before they stand, as long as their poses
        count; the distance between the edges; and the farthest that the robots may come in any direction. Of each pair,
        the robot that is named first comes first.

        Robots are sorted into squares, so only neighbors are compared.
        """
        tracks = {robot: self.tracks[robot] for robot in bases}
        most, wide = dict[str, Approach](), dict[str, float]()
        for robot, base in bases.items():
            track = tracks[robot]
            most[robot], last = track.most(base, [max(now - track.poses[-1].at, 0.0), base.oldest])
            wide[robot] = base.radius + last.far
        side = bound + 2 * max(wide.values(), default=0.0)
        squares: dict[tuple[int, int], list[str]] = {}
        for robot, base in bases.items():
            pose = tracks[robot].poses[-1].pose
            across, along = math.floor(pose.x / side), math.floor(pose.y / side)
            for square in ((across + i, along + j) for i in (-1, 0, 1) for j in (-1, 0, 1)):
                for other in squares.get(square, ()):
                    far = pose.apart(tracks[other].poses[-1].pose)[0]
                    if far - wide[robot] - wide[other] < bound:
                        gap = far - base.radius - bases[other].radius
                        yield (other, robot), gap, _together(most[robot], most[other])
            squares.setdefault((across, along), []).append(robot)


class Looked(NamedTuple):
    """The result of a check: the new state; the pairs that are too near, the nearest first; and the time of the next
    check if no pose comes, and no robot is sent another velocity."""

    proximity: Proximity
    found: list[Near]
    due: float


def as_line(found: Collection[Near], keep_apart: float) -> str:
    """Return a line for people about robots that are too near to each other."""
    each = [
        f"{one} and {other} are {max(gap, 0.0):.2f} m apart{f' and approach at {approach:.2f} m/s' if approach else ''}"
        for (one, other), gap, approach in [*found][:MAX_NAMED]
    ]
    more = f" (and {len(found) - MAX_NAMED} more pairs)" if len(found) > MAX_NAMED else ""
    return f"paused: {', '.join(each)}{more}, and `keep_apart` is {keep_apart:g} m: make room, then resume"


def _together(one: Approach, other: Approach) -> Approach:
    return Approach(one.far + other.far, one.grows + other.grows)


def _may_leave(since: Since, gap: float, rest: float, now: float) -> bool:
    """Return whether two robots that were too near since a time may move apart."""
    return since.gap - JITTER <= rest and (now < since.at + PATIENCE or gap > since.gap + JITTER)
