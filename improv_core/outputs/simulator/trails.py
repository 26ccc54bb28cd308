"""Where a robot has been: places that an arc joins, each to the next. Standard library only."""

from __future__ import annotations

import math
from typing import NamedTuple

from improv_core.score.motion import Pose

MOST_PLACES = 20_000
"""Places kept of one trail: an hour and a half, if the robot moves differently four times a second."""
SHARPEST = 1.0
"""Radians that a robot may turn between two places. Below half a turn, there is only one arc between two poses."""


class TimedPose(NamedTuple):
    """Where a robot was, in meters and radians, `at` seconds after beat 0."""

    at: float
    x: float
    y: float
    heading: float


class Trail:
    """The places of one robot, oldest first. Between two places, it has moved along the one arc that joins their poses.

    It only ever becomes longer, at its end, so any thread may read it. `until` is the time of the latest place in
    seconds.
    """

    def __init__(self, at: float, pose: Pose) -> None:
        self.until = -math.inf
        self.places: list[TimedPose] = []
        self.add(at, pose)

    def add(self, at: float, pose: Pose) -> None:
        """Add where the robot is. While it stands, nothing is added between its arrival and its departure."""
        here = TimedPose(at, pose.x, pose.y, pose.heading)
        stood = len(self.places) > 1 and self.places[-1][1:] == self.places[-2][1:] == here[1:]
        if at > self.until and not stood:
            self.places.append(here)
        self.until = max(at, self.until)

    def bend(self, at: float, pose: Pose) -> None:
        """Add where a robot is that moves along an arc, if it has turned far since the latest place."""
        if abs(pose.heading - self.places[-1].heading) > SHARPEST:
            self.add(at, pose)

    def renewed(self) -> Trail:
        """The trail without its older half, once it has too many places."""
        if len(self.places) <= MOST_PLACES:
            return self
        trail = Trail(self.until, Pose())
        trail.places = self.places[MOST_PLACES // 2 :]
        return trail
