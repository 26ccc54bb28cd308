"""The messages between a stage and the reader of sensors (docs/protocol.md). Standard library only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict

from improv_core.protocol.fields import PoseJson
from improv_core.protocol.json_lines import Alive


class SenseToRead(TypedDict):
    """A sense of a robot; `source` as in a score, with a topic."""

    robot: str
    sense: str
    source: Mapping[str, Any]


class Read(TypedDict):
    """Read these senses, and the poses, batteries, and joint states of these robots (robot: topic), and no others.
    `bases` are the robots' own frames in tf. `period` is the seconds between checks for poses."""

    type: Literal["read"]
    period: float
    senses: Sequence[SenseToRead]
    odometry: Mapping[str, str]
    bases: Mapping[str, str]
    batteries: Mapping[str, str]
    joint_states: Mapping[str, str]


class EdgeMessage(TypedDict):
    """A sense of a robot has become true or false, or silent (null), at a time on the monotonic clock."""

    type: Literal["edge"]
    robot: str
    sense: str
    value: bool | None
    at: float


class Unread(TypedDict):
    """A topic can't be read at all; `message` is one line with the reason."""

    type: Literal["unread"]
    topic: str
    message: str


class MeasuredPose(TypedDict):
    """A robot's pose in the frame of its source (the type of the message on a topic), at a time on the monotonic clock.

    `stamp` is the time in the message, on that clock if the clocks agree; null if it has none.
    """

    robot: str
    source: str
    frame: str
    pose: PoseJson
    at: float
    stamp: float | None
    topic: str


class MeasuredPoses(TypedDict):
    """The latest poses of robots, at most twenty a second of each."""

    type: Literal["poses"]
    poses: Sequence[MeasuredPose]


class Batteries(TypedDict):
    """The charges of robots' batteries, from 0 to 1."""

    type: Literal["batteries"]
    batteries: Mapping[str, float]


class MeasuredJoints(TypedDict):
    """The positions of a robot's joints, in radians or meters, at a time on the monotonic clock; at most twenty times a
    second."""

    type: Literal["joints"]
    robot: str
    positions: Mapping[str, float]
    at: float


ToReader = Read
"""From the stage to the reader of sensors, over a pipe."""
FromReader = EdgeMessage | MeasuredPoses | Batteries | MeasuredJoints | Alive | Unread
