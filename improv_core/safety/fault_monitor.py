"""All robots as they are watched for faults: what comes in between two looks, and when to look. `faults.py` decides.

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
"""Seconds in which every robot is looked at once."""
TOGETHER = 100
"""So many robots are looked at together, so that what is new of them at once is told in one line: more would take
longer than a command may wait."""


class RobotNews(NamedTuple):
    """What is new about a robot's faults."""

    robot: str
    news: News


class Watches:
    """What is known of each robot since the last look at it."""

    def __init__(self) -> None:
        self._watches: dict[str, RobotWatch] = {}
        self._poses: dict[str, list[Comparison]] = {}
        self._moves: dict[str, float] = {}  # since when robots have been told to move
        self._late: dict[str, float] = {}
        self._looked = -math.inf
        self._place = 0  # how many robots have been looked at in this round
        self.posed: dict[str, float] = {}
        """When the latest pose of each robot came."""
        self._moved: set[str] = set()
        self.unreached: set[str] = set()
        """Robots that have been told to move and that are out of reach now: gone, or silent."""

    def restart(self) -> None:
        """Another performance begins."""
        self._watches, self._poses, self._late, self.posed = {}, {}, {}, {}
        self._moved, self.unreached = set(), set()

    def take(self, pose: Comparison) -> None:
        """A pose has been measured."""
        self._poses.setdefault(pose.raw.robot, []).append(pose)
        self.posed[pose.raw.robot] = pose.raw.at

    @property
    def next_look(self) -> float:
        """When to look around again: a bit later than that would be due, whatever is rounded."""
        return self._looked + PERIOD * (1 + 1e-6)

    def tell(self, robot: str, twist: Twist, at: float) -> None:
        """A robot has been told to move, or to stand."""
        if twist == STILL:
            self._moves.pop(robot, None)
        else:
            self._moves.setdefault(robot, at)
            self._moved.add(robot)

    def look_around(self, score: Score, gone: Collection[str], noticed: Noticed, now: float) -> Iterator[RobotNews]:
        """Look at as many robots as the time since the last look asks for, if that is due, and find what is new."""
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
        """What is new about a robot, with the other one if they seem to be swapped."""
        robot, news = found
        if not isinstance(news, FaultBegan) or news.fault != "jumped":
            return found
        watch = self._watches[robot]
        others = (other for other, each in self._watches.items() if other != robot and are_swapped(watch, each))
        return RobotNews(robot, news._replace(swapped=next(others, "")))

    def _forget(self, parts: Mapping[str, Part]) -> None:
        """Forget robots that have left."""
        for robot in self._watches.keys() - parts.keys():
            del self._watches[robot]
            self.posed.pop(robot, None)
            self._moves.pop(robot, None)
            self._moved.discard(robot)
            self.unreached.discard(robot)


_UNWATCHED = RobotWatch()
