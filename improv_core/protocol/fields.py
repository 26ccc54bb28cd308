"""The fields that several messages have: numbers, names, and texts, each with its limits. Standard library only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Annotated, Literal, TypedDict

from improv_core.score.json_types import Between, Long
from improv_core.score.motion import Pose

SLOWEST, FASTEST = 0.1, 4.0
"""Limits of the speed factor."""
LAST_BEAT = 1e15
"""The last beat to which one can seek: beyond it, numbers in JavaScript are no longer exact."""
LONGEST_TEXT = 100_000
"""The most characters of a program that can be edited on the page: a browser would need too long to lay out more."""


class _Savable:
    """The limit of a text that can be saved: it has no halves of characters."""

    def holds(self, value: str) -> bool:
        try:
            value.encode()
        except UnicodeEncodeError:
            return False
        return True


class _Drawn:
    """The limits of a point of a stroke: its beat, x, and y."""

    def holds(self, value: Sequence[float]) -> bool:
        return 0 <= value[0] <= LAST_BEAT and max(map(abs, value[1:])) <= 1000


class _Pressed:
    """The limits of keys that are held from a beat on."""

    def holds(self, value: Sequence[float]) -> bool:
        return 0 <= value[0] <= LAST_BEAT and all(each in (-1, 0, 1) for each in value[1:])


Count = Annotated[int, Between(0, LAST_BEAT)]
Beat = Annotated[float, Between(0, LAST_BEAT)]
Patience = Annotated[float, Between(0.5, 10)]
Factor = Annotated[float, Between(SLOWEST, FASTEST)]
SongTime = Annotated[float, Between(-3600, 3600)]
Name = Annotated[str, Long(1, 1_000)]
Names = Annotated[Sequence[Name], Long(0, 10_000)]
Text = Annotated[str, Long(0, LONGEST_TEXT), _Savable()]
"""The values that people may send: numbers, names, and texts within their limits."""


def within_reach(pace: float) -> Fraction:
    """Return a pace within the limits of the speed factor, exact."""
    return Fraction(round(min(max(pace, SLOWEST), FASTEST) * 1_000_000), 1_000_000)


class PoseJson(TypedDict):
    """A pose in meters and radians."""

    x: float
    y: float
    z: float
    heading: float


def to_pose_json(pose: Pose) -> PoseJson:
    return {"x": pose.x, "y": pose.y, "z": pose.z, "heading": pose.heading}


class StartPoseJson(TypedDict):
    """A start pose in meters and degrees, within the limits of improv.toml."""

    x: Annotated[float, Between(-1000, 1000)]
    y: Annotated[float, Between(-1000, 1000)]
    heading: Annotated[float, Between(-360, 360)]


StartPoses = Annotated[Mapping[Name, StartPoseJson], Long(0, 10_000)]
Shape = Literal["line", "circle", "grid"]
Facing = Literal["in", "out"]
Distance = Annotated[float, Between(0.001, 1000)]
"""Meters between neighbors of a formation."""
Meters = Annotated[float, Between(-1000, 1000)]
Place = Annotated[Sequence[Meters], Long(2, 2)]
Steps = Annotated[int, Between(-1000, 1000)]
Parts = Annotated[int, Between(0, 12)]
DrawnPoints = Annotated[Sequence[Annotated[Sequence[float], Long(3, 3), _Drawn()]], Long(2, 5_000)]
"""The beats and places (x, y in meters) of a stroke."""
Held = Annotated[Sequence[Annotated[Sequence[float], Long(3, 3), _Pressed()]], Long(1, 5_000)]
"""The beats from which keys are held, and the directions that they mean ahead and for a turn: -1, 0, or 1."""
