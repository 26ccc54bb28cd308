"""Outputs, or sinks, turn timed twists into motion, simulated or real."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, Protocol

from improv_core.score.motion import Pose, Twist

if TYPE_CHECKING:  # a standby needs nothing of a score, and little memory
    from improv_core.protocol.messages import FromStage, SentAs
    from improv_core.score.joints import JointMotion
    from improv_core.score.score import Score
    from improv_core.score.senses import Key, RobotSense


class StopButton(NamedTuple):
    """An emergency stop, by its topic."""

    topic: str


@dataclass(frozen=True, slots=True)
class Edge:
    """A change in what people or robots do.

    `what` is a deadman button, an emergency stop, a key, or a robot's sense; the value None is silence. `at` is its
    arrival, in monotonic seconds; for a sense of a simulated robot, in performance time.
    """

    what: str | StopButton | Key | RobotSense
    value: bool | None
    at: float


@dataclass(frozen=True, slots=True)
class Alarm:
    """Real robots must stop: `message` is one line that reports the stop, its reason, and what to do."""

    message: str


class RawPose(NamedTuple):
    """A robot's pose in the frame of its source: the type of the message, or the simulator.

    `at` is its arrival, in monotonic seconds, and `frame` the name of that frame. `stamp` is the time in the message,
    in monotonic seconds if its source's clock agrees with this machine's; None if it has none. `topic` is the topic on
    which it came; "" in the simulator. `told` is the velocity that the robot had been sent by then, if another stage
    reports it.
    """

    robot: str
    source: str
    pose: Pose
    at: float
    frame: str = ""
    stamp: float | None = None
    topic: str = ""
    told: Twist | None = None


@dataclass(frozen=True, slots=True)
class RawPoses:
    """The latest poses of robots that have moved or may have; at most twenty of each robot come in a second."""

    poses: Sequence[RawPose]


class Unfollowed(NamedTuple):
    """Joints of a robot haven't followed for some seconds; `why` names their controller and the likely cause."""

    seconds: float
    why: str


@dataclass(frozen=True, slots=True)
class Noticed:
    """The observations of a sink of real robots: all poses that were sent by `heard`, in monotonic seconds, have come.
    By robot, the commands since the last time left `late` by at most this many seconds, if they did. `batteries` are
    their charges, from 0 to 1. Joints of the robots in `unfollowed` don't follow. The time of the simulation is
    `frozen` if it stamps messages and stands still."""

    heard: float = math.inf
    late: Mapping[str, float] = field(default_factory=dict)
    batteries: Mapping[str, float] = field(default_factory=dict)
    unfollowed: Mapping[str, Unfollowed] = field(default_factory=dict)
    frozen: bool = False


class RawJoints(NamedTuple):
    """The positions of a robot's joints, in radians or meters. `at` is their arrival, in monotonic seconds."""

    robot: str
    positions: Mapping[str, float]
    at: float


class ZeroRetries(Protocol):
    """Zeros that robots may not have received (safety/pending_zeros.py)."""

    @property
    def due(self) -> float:
        """The time at which `retry` is due, in monotonic seconds; infinite if no zero is pending."""

    def retry(self, now: float) -> None:
        """Send them again, or find out that robots have received them."""


class BaseCommand(NamedTuple):
    """A robot's velocity from a performance time on, in seconds since beat 0."""

    robot: str
    twist: Twist
    at: float


class Sink:
    """Something that moves robots. The stage's loop calls it from one thread only.

    By default, its robots are ready at once, have no joints, and sense nothing, and only commands change anything.
    """

    name: str
    """Its name in the status: "simulator", "ROS 2"."""

    real: bool
    """True if it moves real robots, which keep moving while nothing is sent. Late setpoints must not reach them."""

    period: float | None = None
    """Seconds between calls of `advance` while something plays; None if it needs no calls."""

    pending_zeros: ZeroRetries | None = None
    """The zeros that robots may not have received, if it knows."""

    @property
    def description(self) -> str:
        """Its name and its reach, in words."""
        return self.name

    def show(self, message: FromStage) -> None:
        """Pass a message of the stage on to others who watch, if it has any."""

    def announce(self, score: Score, generation: int) -> None:
        """Tell others who watch of a score before it plays."""

    def guard(self, topics: Collection[str]) -> None:
        """Listen for the release of these emergency stops, which are on, even if no score names them."""

    def preload(self, score: Score) -> Iterator[None]:
        """Get to know the robots of a score that will be prepared soon, so that new ones can be sent commands at once.
        Each step takes a few milliseconds at most. Nothing changes for the robots that play."""
        return iter(())

    def prepare(self, score: Score, restart: bool) -> None:
        """Get ready to play a score. With `restart`, move its robots to their start poses if possible.

        Keeps the robots of earlier calls. Called before the first `send` of each new score.
        """
        raise NotImplementedError

    def resetting(self, homing: Collection[str] = ()) -> bool:
        """Return whether beat 0 must wait for robots to reach their start poses or for an emergency stop. Call it
        repeatedly before beat 0, and not after: once only joints hold that back, it brings those of the robots in
        `homing`, which may move, to their starts, if the settings ask for that. The joints of all others stand."""
        return False

    def posed(self) -> Collection[str]:
        """Return the robots of which a pose has come since it was asked for, even if it is still on its way."""
        return ()

    def ask(self, robots: Collection[str]) -> None:
        """Have the listeners of these robots, which stand, confirm that they receive a zero, unless they have. Call it
        repeatedly until they are no longer `missing`."""

    def missing(self, robots: Collection[str] | None = None) -> dict[str, str]:
        """Return one line for each of these robots (default: all of the latest `prepare`) that would not receive a
        command. The line is empty for a robot that will be ready in a moment."""
        return {}

    def warnings(self, robots: Collection[str] | None = None) -> dict[str, str]:
        """Return one line for each of these robots (default: all of the latest `prepare`) that people should know
        about. A line about the whole performance has another key, such as a topic."""
        return {}

    def other_publishers(self) -> Mapping[str, Collection[str]]:
        """Return the robots that others can also move, each with the names of these others, as of the latest
        `warnings`."""
        return {}

    def send(self, robot: str, twist: Twist, at: float) -> None:
        """Set the robot's velocity from performance time `at` on (seconds since beat 0, never decreasing). Only `ready`
        calls it."""
        raise NotImplementedError

    def ready(self, commands: Sequence[BaseCommand]) -> Callable[[], None]:
        """Get commands ready, and return a function that sends them, as fast as possible. If it can't send one, it
        still sends the others, and then raises the first exception."""
        return partial(try_all, [partial(self.send, *command) for command in commands])

    def sent_as(self, robot: str) -> SentAs:
        return {"stamped": False}

    def send_joints(
        self, robot: str, joints: Mapping[str, JointMotion], at: float, pace: float = 1.0, until: float = math.inf
    ) -> None:
        """Move some of a robot's joints from performance time `at` on. One that reaches its limit gets a new
        command then. They move like that `until` a performance time, at which the next command comes. A stop lasts no
        time: they brake as hard as they may. Velocities are by a time of which `pace` passes in a second, as in a
        simulation."""

    def place(self, poses: Mapping[str, Pose]) -> None:
        """Move robots to other poses, if possible."""

    def advance(self, to: float, asked: Collection[RobotSense] = ()) -> list[Edge]:
        """Advance to performance time `to` (seconds since beat 0). Every twist up to then has been sent.

        A simulator stops when senses in `asked` change. Returns these edges, sorted; none once it is at `to`. Real
        robots' sensors report by themselves.
        """
        return []

    def coasting(self) -> bool:
        """True while robots that were sent zeros still move. Until they stand, `advance` is called."""
        return False

    def poses(self) -> dict[str, Pose]:
        """Return the poses of the robots if the sink knows them, otherwise nothing."""
        return {}

    def noticed(self) -> Noticed:
        """Return its observations of real robots since the last call."""
        return Noticed()

    def close(self) -> None:
        """Release all resources. The robots have already been stopped."""


def try_all(calls: Iterable[Callable[[], None]]) -> None:
    """Make each of these calls, even if others fail, and then raise the first exception."""
    problems = list[Exception]()
    for call in calls:
        try:
            call()
        except Exception as problem:  # a sink's library may raise anything
            problems.append(problem)
    if problems:
        raise problems[0]
