"""How far robots were off the ideal paths of a performance, from what was measured of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from improv_core.score.motion import Pose


class Deviation(NamedTuple):
    """How far a robot is from where it ideally is, in meters, and how far it is turned, in radians."""

    distance: float
    turn: float

    def __str__(self) -> str:
        degrees = round(math.degrees(self.turn))
        return f"{self.distance:.2f} m, {degrees} degree{'' if degrees == 1 else 's'} off"


class Errors:
    """The largest and the last error of each robot in a performance."""

    def __init__(self) -> None:
        self.robots: dict[str, tuple[Deviation, Deviation]] = {}
        """The largest distance and turn, and the last error."""

    def take(self, message: Mapping[str, Any]) -> None:
        """Take a message `measured` (docs/protocol.md)."""
        for robot, each in message["robots"].items():
            last = error(each["pose"], each["ideal"])
            largest, _ = self.robots.get(robot, (last, last))
            self.robots[robot] = Deviation(*map(max, largest, last)), last

    def as_json(self) -> dict[str, Any]:
        """JSON values, in meters and radians."""
        return {
            robot: {"largest": largest._asdict(), "last": last._asdict()}
            for robot, (largest, last) in sorted(self.robots.items())
        }

    def lines(self) -> Iterator[str]:
        """A line about each robot."""
        for robot, (largest, last) in sorted(self.robots.items()):
            yield f"{robot} ended {last}; at most {largest}"


def error(pose: Mapping[str, float], ideal: Mapping[str, float]) -> Deviation:
    """How far a pose is from another one."""
    return Deviation(*Pose(**pose).apart(Pose(**ideal)))
