"""A camera above the floor: what it says of robots' poses, late and sometimes wrong. It never reads a clock."""

from __future__ import annotations

import math
import random
from collections import deque
from collections.abc import Iterator, Mapping, Sequence

from tests.ros.physics.faults import Fault

Pose = tuple[float, float, float]
"""Meters and radians."""


class Camera:
    """Takes a picture of all robots and says what it saw `latency` seconds later. Of its poses, a `loss` is dropped."""

    def __init__(self, latency: float, loss: float, seed: int) -> None:
        self._latency, self._loss = latency, loss
        self._lots = random.Random(seed)
        self._waiting: deque[tuple[float, str, Pose, float]] = deque()

    def look(self, poses: Mapping[str, Pose], faults: Sequence[Fault], now: float) -> None:
        """Take a picture of where robots are."""
        for robot in poses:
            called, (x, y, heading) = robot, poses[robot]
            late, loss = self._latency, self._loss
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
        """Each robot that it saw, where, and when, as far as that is said by now."""
        for each in [each for each in self._waiting if each[0] <= now]:
            self._waiting.remove(each)
            _, robot, pose, at = each
            yield robot, pose, at
