"""A robot's trail: the places where it was, joined by arcs. Standard library only."""

from __future__ import annotations

import math
from typing import NamedTuple

from improv_core.score.motion import Pose

MOST_PLACES = 20_000
"""The most places kept in one trail: an hour and a half, if the robot changes its movement four times a second."""
SHARPEST = 1.0
"""The most radians that a robot turns between two places. Below half a turn, only one arc joins two poses."""


class TimedPose(NamedTuple):
    """A robot's pose in meters and radians, `at` seconds after beat 0."""

    at: float
    x: float
    y: float
    heading: float


class Trail:
    """The places of one robot, oldest first. Between two places, it moved along the one arc that joins their poses.

    A trail only grows, at its end, so any thread may read it. `until` is the time of the latest place in seconds.
    """

    def __init__(self, at: float, pose: Pose) -> None:
        self.until = -math.inf
        self.places: list[TimedPose] = []
        self.add(at, pose)

    def add(self, at: float, pose: Pose) -> None:
        """Add the robot's pose. While it stands, only its arrival and its departure are added."""
        here = TimedPose(at, pose.x, pose.y, pose.heading)
        stood = len(self.places) > 1 and self.places[-1][1:] == self.places[-2][1:] == here[1:]
        if at > self.until and not stood:
            self.places.append(here)
        self.until = max(at, self.until)

    def bend(self, at: float, pose: Pose) -> None:
        """Add the pose of a robot on an arc if it has turned far since the latest place."""
        if abs(pose.heading - self.places[-1].heading) > SHARPEST:
            self.add(at, pose)

    def renewed(self) -> Trail:
        """Return the trail without its older half if it has too many places."""
        if len(self.places) <= MOST_PLACES:
            return self
        trail = Trail(self.until, Pose())
        trail.places = self.places[MOST_PLACES // 2 :]
        return trail
