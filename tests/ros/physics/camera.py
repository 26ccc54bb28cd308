"""A camera above the floor, which reports robots' poses late and sometimes wrong. It never reads a clock."""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Iterator, Mapping, Sequence

from tests.ros.physics.faults import Fault

Pose = tuple[float, float, float]
"""A pose in meters and radians."""


LATENCY = 0.08
"""Seconds from a picture to the report of its poses."""


class Camera:
    """A camera that loses a share `loss` of the poses."""

    def __init__(self, loss: float) -> None:
        self._loss = loss
        self._lots = random.Random(1)
        self._waiting: deque[tuple[float, str, Pose, float]] = deque()

    def look(self, poses: Mapping[str, Pose], faults: Sequence[Fault], now: float) -> None:
        """Take a picture of the robots."""
        for robot in poses:
            called, (x, y, heading) = robot, poses[robot]
            late, loss = LATENCY, self._loss
            for fault in faults:
                if robot not in fault.robots:
                    continue
                if fault.kind == "swap":
                    called = next(name for name in fault.robots if name != robot)
                elif fault.kind == "jump":
                    x, y = x - fault.amount * math.sin(heading), y + fault.amount * math.cos(heading)
                elif fault.kind == "lost":
                    loss = max(loss, fault.amount)
                elif fault.kind == "late":
                    late += fault.amount
            if self._lots.random() >= loss:
                self._waiting.append((now + late, called, (x, y, heading), now))

    def say(self, now: float) -> Iterator[tuple[str, Pose, float]]:
        """Yield the robot, the pose, and the time of each observation whose latency is over by now."""
        for each in [each for each in self._waiting if each[0] <= now]:
            self._waiting.remove(each)
            _, robot, pose, at = each
            yield robot, pose, at
