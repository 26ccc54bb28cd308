"""A robot's base on ROS 2: its topic and its serialized velocities."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from improv_core.outputs.cdr import twist_message
from improv_core.outputs.ros.topic import RosTopic
from improv_core.protocol.output import BaseCommand
from improv_core.score.motion import STILL, Twist
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

    def serialized(self, command: BaseCommand, clock: Any) -> SerializedCommand:
        """Return a command as it is published. ROS's `clock` stamps it then."""
        stands = self.is_held or command.twist == STILL
        message = self.message_of(STILL if stands else command.twist)
        return SerializedCommand(command, self, stands, self.topic.ready(message, clock, self.part.frame))

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


class SerializedCommand(NamedTuple):
    """A command to a base, and functions that send its message. One that `stands` is a zero."""

    command: BaseCommand
    base: RosBase
    stands: bool
    sends: Sequence[Callable[[], None]]


def publish_all(commands: Sequence[SerializedCommand]) -> dict[str, Exception]:
    """Publish commands, with nothing in between, so that the last of a hundred robots doesn't wait for long. Return the
    exceptions by robot."""
    problems = dict[str, Exception]()
    for command, _, _, sends in commands:
        try:
            for send in sends:
                send()
        except Exception as problem:  # rclpy may raise anything
            problems[command.robot] = problem
    return problems
