"""Sends setpoints when they are due: changes of velocity from a queue, and repeats in between.

It never reads a clock; times are performance times, in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from heapq import heapify, heappop, heappush
from typing import NamedTuple

from improv_core.score.motion import STILL, Twist
from improv_core.score.score import Part
from improv_core.stage.repeats import Repeats
from improv_core.stage.setpoints import LAST_ZEROS, Setpoint, zeros


class SetpointQueue:
    """The next setpoint of each robot, and the velocities that robots hold.

    `send` sends a robot a velocity at a performance time. `is_silent` is asked whether a robot must stand now although
    its part moves it.
    """

    def __init__(self, send: Callable[[str, Twist, float], None], is_silent: Callable[[str], bool]) -> None:
        self._send_now = send
        self._is_silent = is_silent
        self._queue: list[_Due] = []
        self._wanted: dict[str, Twist] = {}  # each robot's velocity, or what it would be if the robot were not silent
        self._zeros_left: dict[str, int] = {}  # for each silent robot
        self.repeats = Repeats()
        """The robots that hold a velocity."""

    @property
    def due(self) -> float:
        """When the next change is due."""
        return self._queue[0].at if self._queue else math.inf

    def restart(self, robots: Collection[str], performed: float) -> None:
        """Performance time starts over, and these robots begin. Those that left before still get their last zeros."""
        left = [due for due in self._queue if due.robot not in robots]
        self._queue = [due._replace(at=due.at - performed, offset=due.offset - performed) for due in left]
        heapify(self._queue)
        self._wanted = {}
        self.repeats.restart()

    def begin(self, robots: Collection[str]) -> None:
        """Get ready for new setpoints of these robots."""
        self.drop(robots)
        for robot in robots:
            self._zeros_left[robot] = LAST_ZEROS if self._is_silent(robot) else 0

    def drop(self, robots: Collection[str]) -> None:
        """Drop the setpoints of robots. Those that have left the score still get their zeros."""
        self.drop_changes(robots)
        for robot in robots:
            self.repeats.release(robot)

    def drop_changes(self, robots: Collection[str]) -> None:
        """Drop the setpoints of robots, which hold their velocities."""
        self._queue = [due for due in self._queue if due.robot not in robots]
        heapify(self._queue)

    def add(self, robot: str, told: Iterator[Setpoint], offset: float) -> None:
        """Send a robot these setpoints, whose times count from `offset`."""
        if following := next(told, None):
            at, twist, held = following
            heappush(self._queue, _Due(at + offset, robot, twist, held, told, offset))

    def begin_open(self, robot: str, at: float) -> None:
        """An open part begins: whatever it does first is sent."""
        self._wanted.pop(robot, None)
        self.add_open(robot, at)

    def add_open(self, robot: str, at: float) -> None:
        """A robot's open part is to be performed at this time."""
        heappush(self._queue, _Due(at, robot, None, True, iter(()), 0.0))

    def hold(self, robot: str, moving: Twist, rate: float, at: float) -> None:
        """Send a robot a velocity if it is a new one, and repeat it at `rate` Hz."""
        if moving != self._wanted.get(robot):
            self._send(robot, moving, at)
            self.repeats.hold(robot, rate, at)

    def send_changes(self, until: float, parts: Mapping[str, Part], perform: Callable[[str, float], None]) -> None:
        """Send every change until then, and only then compute the next ones. `perform` performs open parts."""
        due = []
        while self._queue and self._queue[0].at <= until:
            due.append(heappop(self._queue))
        sent = 0
        try:
            for each in due:
                sent += 1
                if each.twist is None:
                    perform(each.robot, each.at)
                else:
                    self._send(each.robot, each.twist, each.at)
        finally:
            # Also if a robot can't be reached: it must not come first again and hold up the zeros of the others.
            for at, robot, moving, held, rest, offset in due[:sent]:
                if moving is None:
                    continue
                if held:
                    self.repeats.hold(robot, parts[robot].profile.command_rate, at)
                else:
                    self.repeats.release(robot)
                self.add(robot, rest, offset)
            for each in due[sent:]:
                heappush(self._queue, each)

    def send_repeats(self, performed: float) -> None:
        """Send the repeats of one slot if they are due."""
        if self.repeats.due <= performed:
            for robot in self.repeats.take(performed):
                self._send(robot, self._wanted[robot], performed)

    def resend(self, robot: str, at: float) -> None:
        """Send a robot what it does now that it has become silent, or no longer is."""
        self.silence([robot])
        self._send(robot, self._wanted.get(robot, STILL), at)

    def silence(self, robots: Collection[str]) -> None:
        """Send robots that have become silent their last zeros instead of what follows."""
        self._zeros_left.update(dict.fromkeys(robots, LAST_ZEROS))

    def stop(self, parts: Mapping[str, Part], performed: float) -> list[Exception]:
        """Stop robots at once. If one can't be stopped, the others still are; returns the exceptions."""
        self.drop(parts)
        problems = []
        for robot, part in parts.items():
            burst = zeros(performed, 1 / part.profile.command_rate)
            try:
                self._send_now(robot, STILL, next(burst).at)
            except Exception as problem:  # a sink's library may raise anything
                problems.append(problem)
            self.add(robot, burst, 0.0)
        return problems

    def leave_topics(self, before: Mapping[str, Part], after: Mapping[str, Part], performed: float) -> None:
        """Stop robots at once whose topic or message type changes, and those that leave while another one takes their
        topic."""
        taken = {part.topic for part in after.values()}
        for robot, part in before.items():
            later = after.get(robot)
            moved = later and (later.topic, later.profile.message) != (part.topic, part.profile.message)
            if moved or (not later and part.topic in taken):
                for _ in range(LAST_ZEROS):
                    self._send_now(robot, STILL, performed)

    def stop_leaving(self, before: Mapping[str, Part], after: Mapping[str, Part], performed: float) -> None:
        """Send robots that have left their last zeros, unless another robot has their topic now."""
        taken = {part.topic for part in after.values()}
        for robot in before.keys() - after.keys():
            part = before[robot]
            if part.topic not in taken:
                self.add(robot, zeros(0.0, 1 / part.profile.command_rate), performed)

    def _send(self, robot: str, moving: Twist, at: float) -> None:
        self._wanted[robot] = moving
        if self._is_silent(robot):
            left = self._zeros_left.get(robot, 0)
            if not left:
                return
            self._zeros_left[robot], moving = left - 1, STILL
        self._send_now(robot, moving, at)


class _Due(NamedTuple):
    """A robot's next setpoint at a performance time, and the rest of them, whose times count from `offset`.

    A setpoint without a twist is that of an open part: what it is depends on what is sensed when it is due.
    """

    at: float
    robot: str
    twist: Twist | None
    held: bool
    rest: Iterator[Setpoint]
    offset: float
