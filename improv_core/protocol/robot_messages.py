"""The messages about the faults of robots, how they are, and what their joints were told (docs/protocol.md).

Standard library only.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, TypedDict

from improv_core.score.faults import Fault, Response


class Instant(TypedDict):
    """A beat, the seconds since beat 0 (`performed`), and the Unix time in nanoseconds (`wall`)."""

    beat: float
    performed: float
    wall: int


class RobotInstant(Instant):
    """When a robot sensed or decided something in the score of this generation."""

    generation: int
    robot: str


class JointPositions(RobotInstant):
    """Where joints of a real robot were, in radians or meters."""

    type: Literal["joints"]
    positions: Mapping[str, float]


class WorstJson(TypedDict, total=False):
    """How bad a fault is or was: meters and radians off or jumped, seconds for which it lasts, or a command is late."""

    distance: float
    turn: float
    seconds: float


class FaultMessage(RobotInstant):
    """A fault of a real robot has begun, or is over. `response` is what follows from it: nothing, the robot stands, or
    all robots were stopped. `message` is a line about it, and `line` is what people are told now: the same, or if it is
    new of several robots at once, one line about all of them in the first one's message, and "" in the others'."""

    type: Literal["fault"]
    fault: Fault
    over: bool
    response: Response
    worst: WorstJson
    message: str
    line: str


class Unreached(TypedDict):
    """Robots were told to stop while they were out of reach, so they may still be moving; a line says so."""

    type: Literal["unreached"]
    generation: int
    robots: Sequence[str]
    message: str


class WhyStill(TypedDict):
    """Why real robots stand although nobody at a page has stopped them, in one line; empty if they don't."""

    type: Literal["why_still"]
    line: str


class VitalsRobot(TypedDict):
    """How a real robot is: whether it has a topic of poses (`odom`), when the latest pose came (`posed`, in seconds
    since beat 0), and how full its battery is, from 0 to 1; null if that isn't known. `instead` is what a robot does
    that was away and doesn't play its part; "" for others."""

    odom: bool
    posed: float | None
    battery: float | None
    instead: Literal["", "stands", "drives back"]


class Vitals(TypedDict):
    """How all real robots of a score are."""

    type: Literal["vitals"]
    generation: int
    robots: Mapping[str, VitalsRobot]


class SentJoints(TypedDict):
    """How joints were told to move: where each is, in radians or meters, and how fast it moves."""

    type: Literal["sent_joints"]
    robot: str
    joints: Mapping[str, Sequence[float]]
    wall: int
