"""Reads the section `[formation]` of an `improv.toml`: the places of robots that have no `start` of their own."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from improv_core.robots.schema import known
from improv_core.robots.toml_reading import TomlReading
from improv_core.score.motion import Pose, wrapped
from improv_core.score.profiles import DEFAULT, Profile
from improv_core.score.world import World

_SECTION = ("formation",)


@dataclass(frozen=True, slots=True)
class Formation:
    """A shape around the origin. `distance` is that between the centers of neighbors, in meters."""

    shape: str
    distance: float
    facing: str

    def poses(self, robots: int) -> list[Pose]:
        """Return the places of this many robots: the first one farthest along y, or in the front row of a grid."""
        if self.shape == "circle":
            return on_circle(radius_of(self.distance, robots), robots, self.facing)
        columns = robots if self.shape == "line" else math.ceil(math.sqrt(robots))
        return in_rows(robots, columns, self.distance, self.distance)


def in_rows(robots: int, columns: int, behind: float, beside: float) -> list[Pose]:
    """Return places in rows around the origin, these meters apart, from the front row to the back."""
    front, left = (math.ceil(robots / max(columns, 1)) - 1) / 2, (columns - 1) / 2
    places = [divmod(place, columns) for place in range(robots)]
    return [Pose(behind * (front - row), beside * (left - column)) for row, column in places]


def radius_of(distance: float, robots: int) -> float:
    """Return the radius of the circle on which neighbors are this far apart, along the chord; 0 for a single robot."""
    return distance / 2 / math.sin(math.pi / robots) if robots > 1 else 0.0


def on_circle(radius: float, robots: int, facing: str) -> list[Pose]:
    """Return the poses of robots on a circle: the first one farthest along y, the others counterclockwise. They face
    `in` or `out`; a single one in the middle faces along x."""
    if not radius:
        return [Pose()] * robots
    return [_on_circle(radius, Fraction(90) + Fraction(360 * place, robots), facing) for place in range(robots)]


def _on_circle(radius: float, degrees: Fraction, facing: str) -> Pose:
    angle = math.radians(degrees)
    # Rounded to a nanometer, so that 0 is 0.
    return Pose(
        round(radius * math.cos(angle), 9) + 0.0,
        round(radius * math.sin(angle), 9) + 0.0,
        heading=heading(degrees + 180 * (facing == "in")),
    )


def heading(degrees: Fraction) -> float:
    """Convert degrees to a heading in radians, above -pi and at most pi."""
    return math.radians(wrapped(degrees))


def read_formation(
    reading: TomlReading, table: Mapping[str, Any], robots: Mapping[str, Profile], world: World
) -> Formation | None:
    """Read the formation; None if it has an error. Errors are reported.

    `robots` are those without a `start` that the file lists. If it lists none, a program may have any robots.
    """
    values = reading.entries(_SECTION, table) or {}
    shape, facing, distance = (values.get(name) for name in ("shape", "facing", "distance"))
    if shape and shape != "circle" and "facing" in table:
        reading.at_key((*_SECTION, "facing"), '`facing` works only with `shape = "circle"`: remove it')
    if not shape or ("distance" in table and distance is None):
        return None
    formation = Formation(shape, distance or float(known((*_SECTION, "distance")).default), facing or "in")
    if error := _misfit(formation, robots, world):
        reading.at_value((*_SECTION, "distance"), error, whole=True)
    return formation


def _misfit(formation: Formation, robots: Mapping[str, Profile], world: World) -> str | None:
    """Return the error in the distance, or None."""
    name, widest = max(robots.items(), key=lambda item: item[1].radius, default=("a robot", DEFAULT))
    width = 2 * widest.radius
    if len(robots) != 1 and formation.distance < width:
        who = f"`{name}`" if robots else name
        return f"{who} is {width:g} m wide: make the distance at least that, so that no robots overlap"
    reach = widest.radius
    ends = (
        (pose.x + across, pose.y + along)
        for pose in formation.poses(len(robots))
        for across in (-reach, reach)
        for along in (-reach, reach)
    )
    if not all(world.holds(*end) for end in ends):
        return f"{len(robots)} robots don't fit between the walls: make the distance shorter or the world larger"
    return None
