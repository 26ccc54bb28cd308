"""Watches all robots for faults: collects facts between checks, and decides when to check. `fault_rules` finds
faults.

It never reads a clock; times are the clock's, in seconds.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from improv_core.protocol.output import Noticed
from improv_core.safety.fault_rules import FaultBegan, News, RobotFacts, RobotWatch, are_swapped, look
from improv_core.safety.fault_texts import low_battery
from improv_core.safety.odometry import Comparison
from improv_core.score.motion import STILL, Twist
from improv_core.score.score import Part, Score

PERIOD = 0.1
"""Seconds in which it checks every robot once."""
TOGETHER = 100
"""The number of robots that it checks together, so that one line reports what several have in common. More would take
longer than a command may wait."""


PAUSED = (
    "the simulation is paused, since /clock stands still, but the dance continues: run it, or have the dance follow it "
    'with `follow = "ros"` under [clock] in improv.toml'
)
LOW = (0.2, 0.1)
"""The levels of a battery, from 0 to 1, below which people get a line."""


class RobotNews(NamedTuple):
    """A fault of a robot that has begun or is over."""

    robot: str
    news: News


@dataclass(slots=True)
class _Robot:
    """A robot since its last check: its poses, and by how much its commands left too late. It has been sent
    velocities since `moves`, and ever in this performance if it has `moved`. Its latest pose is of `posed`.

    It was sent `twist` at `since`, after `before`. Earlier `changes` have both velocities, and the seconds until the
    next. In this performance, it was `rushed` if its accelerations don't allow one of them.
    """

    moves: float | None = None
    moved: bool = False
    posed: float | None = None
    late: float = 0.0
    poses: list[Comparison] = field(default_factory=list)
    watch: RobotWatch = field(default_factory=RobotWatch)
    before: Twist = STILL
    twist: Twist = STILL
    since: float = 0.0
    changes: list[tuple[Twist, Twist, float]] = field(default_factory=list)
    rushed: bool = False


class FaultMonitor:
    """The facts about each robot since its last check."""

    def __init__(self) -> None:
        self._robots: defaultdict[str, _Robot] = defaultdict(_Robot)
        self._looked = -math.inf
        self._place = 0  # the number of robots seen in this round
        self._frozen = False  # whether the simulation is paused, as far as people know
        self._low: Mapping[str, float] = {}  # robots whose batteries people know to be low, by the level that they know

    @property
    def posed(self) -> Mapping[str, float]:
        """The time of the latest pose of each robot."""
        return {robot: each.posed for robot, each in self._robots.items() if each.posed is not None}

    @property
    def unreached(self) -> Collection[str]:
        """Robots that have been sent a velocity and are out of reach now: gone, or silent."""
        out = {"gone", "silent"}
        return {robot for robot, each in self._robots.items() if each.moved and not out.isdisjoint(each.watch.open)}

    def restart(self) -> None:
        """Forget what belongs to the previous performance."""
        self._low = {}
        for robot, each in self._robots.items():
            self._robots[robot] = _Robot(moves=each.moves)

    def take(self, pose: Comparison) -> None:
        robot = self._robots[pose.raw.robot]
        robot.poses.append(pose)
        robot.posed = pose.raw.at

    @property
    def next_look(self) -> float:
        """The time of the next check, a little later than a period, so that rounding never makes it too early."""
        return self._looked + PERIOD * (1 + 1e-6)

    def tell(self, robot: str, twist: Twist, at: float) -> None:
        each = self._robots[robot]
        if twist != each.twist:
            if twist != STILL:  # somebody may have stopped it
                each.changes.append((each.before, each.twist, at - each.since))
            each.before, each.twist, each.since = each.twist, twist, at
        if twist == STILL:
            each.moves = None
        else:
            each.moves = at if each.moves is None else each.moves
            each.moved = True

    def simulation(self, noticed: Noticed, score: Score) -> str | None:
        """Return the line about a simulation that has paused, or runs again, unless the dance follows it."""
        before, self._frozen = self._frozen, noticed.frozen
        if before == noticed.frozen or (score.clock and score.clock.follow == "ros"):
            return None
        return PAUSED if noticed.frozen else "the simulation runs again"

    def low_batteries(self, levels: Mapping[str, float]) -> list[str]:
        """Return the lines about batteries that have become low, by their levels from 0 to 1."""
        before = self._low
        self._low = {robot: limit for robot, level in levels.items() for limit in LOW if level < limit}
        fallen = {robot: levels[robot] for robot, limit in self._low.items() if limit < before.get(robot, 1.0)}
        return [low_battery(robots, max(fallen.values())) for robots in [sorted(fallen)] if robots]

    def is_due(self, score: Score, now: float) -> bool:
        """Return whether enough time has passed since the last check for another one."""
        return self._due(score, now) >= min(len(score.parts), TOGETHER)

    def look_around(
        self, score: Score, gone: Mapping[str, str], noticed: Noticed, now: float, back: Collection[str] = ()
    ) -> Iterator[RobotNews]:
        """Check as many robots as the time since the last check requires, and yield what is new. `gone` has a line for
        each robot that has none to listen to it. Robots that drive `back` to their parts move otherwise than these."""
        for robot, seconds in noticed.late.items():
            self._robots[robot].late = max(self._robots[robot].late, seconds)
        robots = list(score.parts)
        due = math.ceil(self._due(score, now))
        news = [
            RobotNews(robot, each)
            for robot in robots[self._place : self._place + due]
            for each in self._look(robot, score.parts[robot], score, gone.get(robot, ""), noticed, now, robot in back)
        ]
        yield from (self._with_swap(each) for each in news)
        self._looked = now
        self._place += due
        if self._place >= len(robots):
            self._place = 0
            for robot in self._robots.keys() - score.parts.keys():
                del self._robots[robot]

    def _due(self, score: Score, now: float) -> float:
        return len(score.parts) * min((now - self._looked) / PERIOD, 1.0)

    def _look(
        self, robot: str, part: Part, score: Score, gone: str, noticed: Noticed, now: float, back: bool
    ) -> list[News]:
        each = self._robots[robot]
        heard, unfollowed = min(noticed.heard, now) if part.odom else None, noticed.unfollowed.get(robot)
        needed = part.profile.seconds_between
        each.rushed = each.rushed or any(needed(before, after) > lasts for before, after, lasts in each.changes)
        lost = gone.removeprefix(f"{robot}: ") if part.device else ""
        known = RobotFacts(now, each.poses, heard, each.moves, bool(gone), each.late, unfollowed, each.rushed, lost)
        if back:
            known = replace(known, moves=None)
        if noticed.frozen and part.use_sim_time:  # it stands because the simulation does
            known = replace(known, heard=None, moves=None)
            each.watch = replace(each.watch, anchor=None)
        each.watch, news = look(each.watch, known, score.safety.faults)
        each.poses, each.late, each.changes = [], 0.0, []
        return news

    def _with_swap(self, found: RobotNews) -> RobotNews:
        """Add the other robot to the news about a jump, if the two seem to be swapped."""
        robot, news = found
        if not isinstance(news, FaultBegan) or news.fault != "jumped":
            return found
        watch = self._robots[robot].watch
        swapped = (other for other, each in self._robots.items() if other != robot and are_swapped(watch, each.watch))
        return RobotNews(robot, news._replace(swapped=next(swapped, "")))
