"""Where velocities go. A sink turns timed twists into motion: simulated or real."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Protocol

from improv_core.score.motion import Pose, Twist
from improv_core.score.score import Score


@dataclass(frozen=True, slots=True)
class Edge:
    """What people or robots do has changed: `what` is a topic, or a button on one; None is silence.

    `at` is when it came, in monotonic seconds.
    """

    what: str
    value: bool | None
    at: float


class Sink(Protocol):
    """Something that moves robots. The stage's loop calls it from one thread only."""

    name: str
    """How it is called in the status: "simulator", "ROS 2"."""

    real: bool
    """Whether robots move while nothing is sent: then what is late must not be sent after all."""

    period: float | None
    """Seconds between two calls of `advance` while something plays, or None if it needs none."""

    def prepare(self, score: Score, restart: bool) -> None:
        """Get ready to play a score; with `restart`, put its robots at their start poses where that is possible.

        Robots of earlier calls are kept. Called before the first `send` of each new score.
        """

    def resetting(self) -> bool:
        """Whether beat 0 should still wait, for robots that are being put at their starts or for an emergency stop.

        To be asked again and again before beat 0, and not after.
        """

    def missing(self, robots: Collection[str] | None = None) -> dict[str, str]:
        """Who of these robots, or all of the latest `prepare`, would not hear a command now: a plain line for each.

        The line is empty for one that will hear commands in a moment.
        """

    def warnings(self, robots: Collection[str] | None = None) -> dict[str, str]:
        """What people should know about these robots, or all of the latest `prepare`, one plain line for each.

        A line about the whole performance is under another key, such as a topic.
        """

    def send(self, robot: str, twist: Twist, at: float) -> None:
        """The robot's velocity from `at` on, in seconds of performance since beat 0 (never decreasing)."""

    def place(self, poses: Mapping[str, Pose]) -> None:
        """Put robots somewhere else, where that is possible."""

    def advance(self, to: float) -> None:
        """Performance time is now `to` seconds since beat 0; every twist up to then has been sent."""

    def coasting(self) -> bool:
        """Whether robots still move that have been told to stop; as long as it is so, `advance` is called on."""

    def poses(self) -> dict[str, Pose]:
        """Where the robots are, if the sink knows; else empty."""

    def close(self) -> None:
        """Let go of everything. The robots have been stopped already."""
