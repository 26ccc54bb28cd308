"""The data about simulated robots that an output hands to pages for drawing. Standard library only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

from improv_core.score.motion import Pose


class Lengthening(Protocol):
    """A trail, which only ever becomes longer, at its end."""

    @property
    def places(self) -> Sequence[Sequence[float]]: ...


class Bump(NamedTuple):
    """A collision of two robots, or of one robot with a `thing` of the world, in words: the time (seconds), the place
    (meters), and the names."""

    at: float
    x: float
    y: float
    robots: tuple[str, ...]
    thing: str = ""


@dataclass(frozen=True, slots=True)
class Snapshot:
    """A picture of the floor: poses at performance time `at` (seconds), radii in meters, trails, and the latest bumps.

    `placed` counts the moves of robots by hand or by a seek: if it differs between two snapshots, robots jumped.
    `joints` has the positions of the joints of robots with a body, in radians or meters.
    """

    at: float = 0.0
    placed: int = 0
    poses: Mapping[str, Pose] = field(default_factory=dict)
    radii: Mapping[str, float] = field(default_factory=dict)
    trails: Mapping[str, Lengthening] = field(default_factory=dict)
    bumps: tuple[Bump, ...] = ()
    joints: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
