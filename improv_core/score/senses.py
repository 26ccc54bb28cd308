"""Senses: facts about a robot that are true or false at every moment, and their sources. Standard library only."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

Message = Literal[
    "sensor_msgs/LaserScan",
    "sensor_msgs/Range",
    "sensor_msgs/Joy",
    "std_msgs/Bool",
    "std_msgs/Float32",
    "nav_msgs/Odometry",
]

BUMP, NEAR, CUE = "bump", "near", "cue"


class RobotSense(NamedTuple):
    """One sense of one robot."""

    robot: str
    sense: str


@dataclass(frozen=True, slots=True)
class Topic:
    """A sense that messages on a ROS topic decide. A relative `topic` is in the robot's namespace.

    `below` or `above` is the limit of a number: of the nearest reading of a scan or a range (meters), of a Float32, of
    the speed in an odometry message (m/s). `start` and `end` are the sector of a scan, in radians counterclockwise from
    straight ahead. `button` of a gamepad is counted from 0; None is any. After `timeout` seconds without a message, its
    value is unknown; 0 if messages come only when something changes.
    """

    topic: str
    message: Message
    below: float | None = None
    above: float | None = None
    start: float = -math.pi
    end: float = math.pi
    button: int | None = None
    timeout: float = 1.0

    def compare(self, number: float) -> bool:
        """Return whether a number is beyond the limit."""
        return number < self.below if self.below is not None else number > (self.above or 0.0)


@dataclass(frozen=True, slots=True)
class Key:
    """A sense that holds while somebody holds a key."""

    key: str


@dataclass(frozen=True, slots=True)
class OscName:
    """A sense that OSC messages with this word decide: it is false before the first one."""

    osc: str


@dataclass(frozen=True, slots=True)
class BuiltIn:
    """A sense that is not declared: the simulator computes `bump` and `near`, and people give the cue."""

    built_in: Literal["bump", "near", "cue"]


BUILT_IN: Mapping[str, BuiltIn] = {BUMP: BuiltIn("bump"), NEAR: BuiltIn("near"), CUE: BuiltIn("cue")}
"""Senses that every robot has: it touches something, something stands ahead of it, somebody gives the cue."""
Source = Topic | Key | OscName | BuiltIn
"""The source of a sense."""
ODOMETRY: Message = "nav_msgs/Odometry"
SECTORS: Mapping[Message, tuple[float, float] | None] = {"sensor_msgs/LaserScan": None, "sensor_msgs/Range": (0.0, 0.0)}
"""Messages about distances, with the sector they measure from the heading if the sense doesn't name one."""
Senses = Mapping[str, Source]
"""The senses that a robot's part reads, by name."""


def is_computed(source: Source) -> bool:
    """Return whether simulators compute a sense; otherwise only a person or a real sensor decides it."""
    if isinstance(source, Topic):
        return source.message in SECTORS or source.message == ODOMETRY
    return isinstance(source, BuiltIn) and source.built_in != CUE


def require_valid(source: Source) -> None:
    """Raise ValueError if a topic that decides a sense has values out of range."""
    if isinstance(source, Topic):
        if not _TOPIC.fullmatch(source.topic):
            raise ValueError("the topic of a sense is not a valid ROS name")
        if not (source.timeout >= 0 and -_TURN <= source.start <= source.end <= _TURN):
            raise ValueError("the timeout or the sector of a sense is out of range")


_TURN = 2 * math.pi
_TOPIC = re.compile(r"(?:/[A-Za-z_][A-Za-z0-9_]*)+")  # rclpy raises an exception for any other name
