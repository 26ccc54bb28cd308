"""Measured distances of robots from the ideal paths of a performance, and from each other."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from improv_core.score.motion import Pose


class Deviation(NamedTuple):
    """A robot's distance from its ideal place, in meters, and from its ideal heading, in radians."""

    distance: float
    turn: float

    def __str__(self) -> str:
        degrees = round(math.degrees(self.turn))
        far, turned = f"{self.distance:.2f} m", f"{degrees} degree{'' if degrees == 1 else 's'}"
        return f"{turned if degrees and far == '0.00 m' else f'{far}, {turned}' if degrees else far} off"


class Nearness(NamedTuple):
    """A distance between two robots in meters, and its time: the beat, and the seconds since beat 0."""

    distance: float
    beat: float
    seconds: float


class SeenFault(NamedTuple):
    """A fault of a robot: the beats from and to which it was seen (None: to the end), and its worst values."""

    robot: str
    fault: str
    begins: float
    ends: float | None
    worst: Mapping[str, float]


SAME_TIME = 0.1
"""The most seconds between measurements of two robots that are compared."""


class Errors:
    """The largest and the last error of each robot in a performance."""

    def __init__(self) -> None:
        self.robots: dict[str, tuple[Deviation, Deviation]] = {}
        """The largest distance and turn, and the last error."""
        self.nearest: dict[tuple[str, str], Nearness] = {}
        """The least distance of each pair that was measured at about the same time."""
        self.faults: list[SeenFault] = []
        """The faults that were seen, in the order in which they began."""
        self.links: dict[str, dict[str, float]] = {}
        """The timing of each host: the worst error of its clock, and the longest that a message took, in seconds."""
        self._latest: dict[str, tuple[float, Pose]] = {}

    def take(self, message: Mapping[str, Any]) -> None:
        """Take a message `measured` (docs/protocol.md)."""
        for robot, each in message["robots"].items():
            self._compare(robot, each)
        for robot, each in message["robots"].items():
            last = error(each["pose"], each["ideal"])
            largest, _ = self.robots.get(robot, (last, last))
            self.robots[robot] = Deviation(*map(max, largest, last)), last

    def note(self, message: Mapping[str, Any]) -> None:
        """Take a message `fault`."""
        robot, fault, beat = message["robot"], message["fault"], message["beat"]
        if not message["over"]:
            self.faults.append(SeenFault(robot, fault, beat, None, message["worst"]))
            return
        for place, seen in enumerate(self.faults):
            if (seen.robot, seen.fault, seen.ends) == (robot, fault, None):
                self.faults[place] = seen._replace(ends=beat, worst=message["worst"])

    def take_link(self, message: Mapping[str, Any]) -> None:
        """Take a message `link` (docs/protocol.md)."""
        known = self.links.get(message["host"], {})
        self.links[message["host"]] = {name: max(message[name], known.get(name, 0.0)) for name in ("error", "lag")}

    def faults_as_json(self) -> list[dict[str, Any]]:
        """Return each fault as JSON values: its robot, its kind, the beats from and to which it was seen, and its
        worst, in meters, radians, and seconds."""
        return [
            {"robot": robot, "kind": fault, "from": begins, "to": ends, "worst": dict(worst)}
            for robot, fault, begins, ends, worst in self.faults
        ]

    def _compare(self, robot: str, measured: Mapping[str, Any]) -> None:
        """Note a robot's distances from the others."""
        at, pose = measured["performed"], Pose(**measured["pose"])
        self._latest[robot] = at, pose
        for other, (then, there) in self._latest.items():
            if other != robot and at - then <= SAME_TIME:
                pair = (robot, other) if robot < other else (other, robot)
                far, _ = pose.apart(there)
                if pair not in self.nearest or far < self.nearest[pair].distance:
                    self.nearest[pair] = Nearness(far, measured["beat"], at)

    def as_json(self) -> dict[str, Any]:
        """Return the errors as JSON values, in meters and radians."""
        return {
            robot: {"largest": largest._asdict(), "last": last._asdict()}
            for robot, (largest, last) in sorted(self.robots.items())
        }

    def lines(self) -> Iterator[str]:
        """Yield a line about each robot, the one that is farthest off first."""
        worst_first = sorted(self.robots.items(), key=lambda each: (-each[1][1].distance, -each[1][1].turn, each[0]))
        for robot, (largest, last) in worst_first:
            yield f"{robot} ended {last}; at most {largest}"


def error(pose: Mapping[str, float], ideal: Mapping[str, float]) -> Deviation:
    """Return the deviation of a pose from another one."""
    return Deviation(*Pose(**pose).apart(Pose(**ideal)))
