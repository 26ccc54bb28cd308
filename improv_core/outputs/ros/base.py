"""A robot's base on ROS 2: its topic and its serialized velocities."""

from __future__ import annotations

import math
from dataclasses import dataclass

from improv_core.outputs.cdr import twist_message
from improv_core.outputs.ros.topic import RosTopic
from improv_core.score.motion import Twist
from improv_core.score.score import Part


@dataclass(slots=True)
class RosBase:
    """A robot of the latest score that names it, and the latest twist sent to it. Most twists are sent repeatedly.

    One that `is_held` gets zeros only: it would never stop by itself, and no standby could stop it.
    """

    part: Part
    topic: RosTopic
    is_simulated: bool = False
    twist: Twist | None = None
    message: bytes = b""
    is_clipped: bool = False
    needs_base: bool = True
    moves_since: float | None = None
    is_held: bool = False

    def message_of(self, twist: Twist) -> bytes:
        """The serialized Twist, calibrated and limited by the profile. Raises ValueError if a number isn't finite."""
        if twist is not self.twist:
            if not all(map(math.isfinite, (twist.x, twist.y, twist.z, twist.yaw))):
                raise ValueError(f"{self.part.robot} was given a speed that is not a finite number")
            calibrated = self.part.profile.calibrated(twist)
            told = self.part.profile.limited(calibrated)
            self.message, self.is_clipped = twist_message(told), told is not calibrated
            self.twist = twist
        return self.message
