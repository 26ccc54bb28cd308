"""Watches all robots for faults: collects facts between two looks, and decides when to look. `fault_rules` finds
faults.

It never reads a clock; times are the clock's, in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

from improv_core.protocol.output import Noticed
from improv_core.safety.fault_rules import FaultBegan, News, RobotFacts, RobotWatch, are_swapped, look
from improv_core.safety.odometry import Comparison
from improv_core.score.motion import STILL, Twist
from improv_core.score.score import Part, Score

PERIOD = 0.1
"""Seconds in which it looks at every robot once."""
TOGETHER = 100
"""The number of robots that it looks at together, so that one line reports what several have in common. More would take
longer than a command may wait."""


class RobotNews(NamedTuple):
    """A fault of a robot that has begun or is over."""

    robot: str
    news: News


class FaultMonitor:
    """The facts about each robot since the last look at it."""

    def __init__(self) -> None:
        self._watches: dict[str, RobotWatch] = {}
        self._poses: dict[str, list[Comparison]] = {}
        self._moves: dict[str, float] = {}  # since when robots have been sent velocities
        self._late: dict[str, float] = {}
        self._looked = -math.inf
        self._place = 0  # the number of robots seen in this round
        self.posed: dict[str, float] = {}
        """The time of the latest pose of each robot."""
        self._moved: set[str] = set()
        self.unreached: set[str] = set()
        """Robots that have been sent a velocity and are out of reach now: gone, or silent."""

    def restart(self) -> None:
        """Forget what belongs to the previous performance."""
        self._watches, self._poses, self._late, self.posed = {}, {}, {}, {}
        self._moved, self.unreached = set(), set()

    def take(self, pose: Comparison) -> None:
        """Take a measured pose."""
        self._poses.setdefault(pose.raw.robot, []).append(pose)
        self.posed[pose.raw.robot] = pose.raw.at

    @property
    def next_look(self) -> float:
        """The time of the next look. It adds a little to the period, so that rounding never makes the look too
        early."""
        return self._looked + PERIOD * (1 + 1e-6)

    def tell(self, robot: str, twist: Twist, at: float) -> None:
        """Note that a robot was sent a velocity, or a zero."""
        if twist == STILL:
            self._moves.pop(robot, None)
        else:
            self._moves.setdefault(robot, at)
            self._moved.add(robot)

    def look_around(self, score: Score, gone: Collection[str], noticed: Noticed, now: float) -> Iterator[RobotNews]:
        """Look at as many robots as the time since the last look requires, and yield what is new. Does nothing if no
        look is due."""
        for robot, seconds in noticed.late.items():
            self._late[robot] = max(self._late.get(robot, 0.0), seconds)
        robots = list(score.parts)
        due = len(robots) * min((now - self._looked) / PERIOD, 1.0)
        if due < min(len(robots), TOGETHER):
            return
        news = [
            RobotNews(robot, each)
            for robot in robots[self._place : self._place + math.ceil(due)]
            for each in self._look(robot, score.parts[robot], score, robot in gone, min(noticed.heard, now), now)
        ]
        yield from (self._with_swap(each) for each in news)
        self._looked = now
        self._place += math.ceil(due)
        if self._place >= len(robots):
            self._place = 0
            self._forget(score.parts)

    def _look(self, robot: str, part: Part, score: Score, gone: bool, heard: float, now: float) -> list[News]:
        poses, late = self._poses.pop(robot, ()), self._late.pop(robot, 0.0)
        known = RobotFacts(now, poses, heard if part.odom else None, self._moves.get(robot), gone, late)
        watch, news = look(self._watches.get(robot, _UNWATCHED), known, score.safety.faults)
        self._watches[robot] = watch
        if robot in self._moved and ("gone" in watch.open or "silent" in watch.open):
            self.unreached.add(robot)
        else:
            self.unreached.discard(robot)
        return news

    def _with_swap(self, found: RobotNews) -> RobotNews:
        """Add the other robot to the news about a jump, if the two seem to be swapped."""
        robot, news = found
        if not isinstance(news, FaultBegan) or news.fault != "jumped":
            return found
        watch = self._watches[robot]
        others = (other for other, each in self._watches.items() if other != robot and are_swapped(watch, each))
        return RobotNews(robot, news._replace(swapped=next(others, "")))

    def _forget(self, parts: Mapping[str, Part]) -> None:
        """Forget robots that are no longer in the score."""
        for robot in self._watches.keys() - parts.keys():
            del self._watches[robot]
            self.posed.pop(robot, None)
            self._moves.pop(robot, None)
            self._moved.discard(robot)
            self.unreached.discard(robot)


_UNWATCHED = RobotWatch()
