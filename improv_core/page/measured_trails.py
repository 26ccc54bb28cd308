"""Measured paths of robots, as pages draw them. Standard library only."""

from __future__ import annotations

from improv_core.protocol.fields import PoseJson
from improv_core.protocol.messages import SIMULATED
from improv_core.protocol.robot_messages import MeasuredRobot
from improv_core.score.motion import Pose

MOST_PLACES = 20_000
"""Places kept for each robot: a quarter of an hour."""


class MeasuredTrail:
    """Measured or simulated places of one robot, oldest first. The trail only grows, at its end."""

    def __init__(self, simulated: bool) -> None:
        self.simulated = simulated
        self.places: list[list[float]] = []

    def renewed(self) -> MeasuredTrail:
        """The trail without its older half, once it has too many places."""
        if len(self.places) <= MOST_PLACES:
            return self
        trail = MeasuredTrail(self.simulated)
        trail.places = self.places[MOST_PLACES // 2 :]
        return trail


def measured_place(robot: MeasuredRobot) -> list[float]:
    """Convert a place to the form that the message to the page uses (`DrawnTrail`)."""
    pose, ideal = robot["pose"], robot["ideal"]
    off, turned = Pose(**pose).apart(Pose(**ideal))
    flags = float(robot["source"] == SIMULATED), float(robot["follows"])
    return [robot["performed"], robot["beat"], *_plane(pose), *_plane(ideal), off, turned, robot["aligned"], *flags]


def _plane(pose: PoseJson) -> tuple[float, float, float]:
    return pose["x"], pose["y"], pose["heading"]
