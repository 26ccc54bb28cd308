"""The messages about robots: their faults, their state, and commands to their joints (docs/protocol.md). Standard
library only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal, TypedDict

from improv_core.protocol.fields import PoseJson
from improv_core.score.faults import Fault, Response
from improv_core.score.json_types import NotRequired, UnixNanoseconds


class Instant(TypedDict):
    """A beat, the seconds since beat 0 (`performed`), and the Unix time in nanoseconds (`wall`)."""

    beat: float
    performed: float
    wall: UnixNanoseconds


class RobotInstant(Instant):
    """The instant at which a robot sensed or decided something in the score of this generation."""

    generation: int
    robot: str


class JointPositions(RobotInstant):
    """The measured positions of a real robot's joints, in radians or meters: at most twenty times a second while robots
    play, and for a second after."""

    type: Literal["joints"]
    positions: Mapping[str, float]


class ShownJoint(TypedDict):
    """A joint, in radians, or in meters if it `slides`. A velocity along `axis` moves it, to greater positions if
    `sign` is 1, and to smaller ones if it is -1."""

    name: str
    axis: str
    sign: int
    slides: bool
    min: float | None
    max: float | None
    start: float


class ShownBodyPart(TypedDict):
    """A body part of a robot, and whether the score moves it."""

    name: str
    joints: Sequence[ShownJoint]
    moves: bool


class RobotLook(TypedDict):
    """The looks of a robot: its profile's name, its `radius` in meters, its `motions`, and the parts of its body."""

    profile: str
    radius: float
    motions: Sequence[str]
    body: Sequence[ShownBodyPart]


class WorstJson(TypedDict, total=False):
    """The largest extent of a fault: meters and radians off or jumped, and seconds of its duration, or of a command's
    delay."""

    distance: float
    turn: float
    seconds: float


class FaultMessage(RobotInstant):
    """A fault of a real robot has begun, or is over. `response` is its effect: nothing, the robot stands, or all robots
    were stopped. `message` is a line about it, and `line` is the line that people see now: the same, or if several
    robots have the same news at once, one line about all of them in the first one's message, and "" in the others'. The
    simulator beside a robot that stands has it stand, too."""

    type: Literal["fault"]
    fault: Fault
    over: bool
    response: Response
    worst: WorstJson
    message: str
    line: str


class Unreached(TypedDict):
    """Robots may still move after a stop or pause: they are gone, silent, or moved by others."""

    type: Literal["unreached"]
    generation: int
    robots: Sequence[str]
    message: str


class WhyStill(TypedDict):
    """The reason why real robots stand although nobody at a page has stopped them, in one line; empty if they don't.
    If nobody has stopped them at all, a page offers to resume from one of these beats."""

    type: Literal["why_still"]
    line: str
    resumes: NotRequired[Resumes]


class Resumes(TypedDict):
    """The beats at which the scene began in which robots were stopped although nobody asked for that, and at which they
    were."""

    scene: float
    beat: float


class VitalsRobot(TypedDict):
    """The state of a real robot: whether it has a topic of poses (`odom`), the time of its latest pose (`posed`, in
    seconds since beat 0), and its battery's charge, from 0 to 1; null if unknown. `instead` describes what a robot does
    that was away and doesn't play its part; "" for others."""

    odom: bool
    posed: float | None
    battery: float | None
    instead: Literal["", "stands", "drives back"]


class Vitals(TypedDict):
    """The states of all real robots of a score, once a second while they play or are paused."""

    type: Literal["vitals"]
    generation: int
    robots: Mapping[str, VitalsRobot]


class MeasuredRobot(Instant):
    """A robot's measured pose, and its ideal pose then.

    `source` is the type of the messages with its poses, or the simulator. `aligned` counts how often the frame of the
    source was aligned with the world of the score: poses with different counts can't be compared. `frame` is the name
    of that frame, and `origin` is the pose of the world's origin in it. `follows` is true if corrections pull the robot
    back to its ideal path.
    """

    source: str
    frame: str
    origin: PoseJson
    pose: PoseJson
    ideal: PoseJson
    aligned: int
    follows: bool


class Measured(TypedDict):
    """The places where robots with `odom`, and simulated ones with motors, really were, and ideally would have been, in
    the world of the score: at most twenty times a second while robots play, and for a second after."""

    type: Literal["measured"]
    generation: int
    robots: Mapping[str, MeasuredRobot]
