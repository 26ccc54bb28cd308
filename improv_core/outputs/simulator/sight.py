"""Visibility of walls, obstacles, and other robots for simulated robots. Points are complex numbers, in meters."""

from __future__ import annotations

import cmath
import math
from typing import NamedTuple

from improv_core.score.motion import Pose
from improv_core.score.world import World

_ROUNDING = 1e-9
_TURN = 2 * math.pi


class Scene(NamedTuple):
    """Visible things: lines from point to point, and discs with their radius. A box is four lines."""

    lines: tuple[tuple[complex, complex], ...] = ()
    discs: tuple[tuple[complex, float], ...] = ()

    def within(self, place: complex, distance: float) -> Scene:
        """The things within a distance of a place."""
        return Scene(
            tuple(line for line in self.lines if abs(_closest(line[0] - place, line[1] - place)) <= distance),
            tuple(disc for disc in self.discs if abs(disc[0] - place) <= distance + disc[1]),
        )

    def seen_from(self, pose: Pose, direction: float = 0.0) -> Scene:
        """The same things seen from a pose: the pose is the origin, and `direction` from its heading is the real
        axis."""
        origin, turn = complex(pose.x, pose.y), cmath.rect(1, -pose.heading - direction)
        return Scene(
            tuple(((one - origin) * turn, (other - origin) * turn) for one, other in self.lines),
            tuple(((center - origin) * turn, radius) for center, radius in self.discs),
        )


def scene(world: World) -> Scene:
    """Everything in a world."""
    lines = [(complex(wall.x1, wall.y1), complex(wall.x2, wall.y2)) for wall in world.all_walls()]
    for x, y, width, height, heading in world.boxes:
        corner, other = complex(width, height) / 2, complex(-width, height) / 2
        turn = cmath.rect(1, heading)
        corners = [complex(x, y) + each * turn for each in (corner, other, -corner, -other)]
        lines += [(corners[place - 1], corners[place]) for place in range(4)]
    return Scene(tuple(lines), tuple((complex(x, y), radius) for x, y, radius in world.circles))


def is_in_the_way(things: Scene, pose: Pose, radius: float, reach: float) -> bool:
    """Return whether a disc would touch something on its next `reach` meters straight ahead. Things that it moves away
    from don't count."""
    seen = things.seen_from(pose)
    return any(_stops(one, other, radius, reach) for one, other in seen.lines) or any(
        center.real > 0 and abs(center - min(center.real, reach)) < radius + size for center, size in seen.discs
    )


def nearest(things: Scene, pose: Pose, start: float, end: float) -> float:
    """The distance of the nearest thing in a sector, from one angle to another, counterclockwise from the heading.

    Infinite if nothing is there.
    """
    seen, width = things.seen_from(pose, start), min(end - start, _TURN)
    lines = (_line_within(one, other, width) for one, other in seen.lines)
    discs = (_disc_within(center, radius, width) for center, radius in seen.discs)
    return min([*lines, *discs], default=math.inf)


def _stops(one: complex, other: complex, radius: float, reach: float) -> bool:
    """Return whether a line stops a disc that moves from 0 along the real axis."""
    close = _closest(one, other)
    if abs(close) < radius:
        return close.real > 0
    ends = min(abs(end - min(max(end.real, 0), reach)) for end in (one, other))
    return ends < radius or abs(_closest(one - reach, other - reach)) < radius or _crossing(one, other, 1) <= reach


def _line_within(one: complex, other: complex, width: float) -> float:
    """The distance of a line from 0 in the sector from the real axis to an angle."""
    points = [each for each in (_closest(one, other), one, other) if _is_within(each, width)]
    return min([*map(abs, points), _crossing(one, other, 1), _crossing(one, other, cmath.rect(1, width))])


def _disc_within(center: complex, radius: float, width: float) -> float:
    if abs(center) <= radius or _is_within(center, width):
        return max(abs(center) - radius, 0.0)
    return min(_hit(center * side, radius) for side in (1, cmath.rect(1, -width)))


def _hit(center: complex, radius: float) -> float:
    """The point at which the positive real axis meets a disc; infinite if it doesn't."""
    if center.real < 0 or abs(center.imag) > radius:
        return math.inf
    return center.real - math.sqrt(radius**2 - center.imag**2)


def _crossing(one: complex, other: complex, ray: complex) -> float:
    """The distance from 0 at which a ray crosses a line; infinite if it doesn't."""
    one, other = one * ray.conjugate(), other * ray.conjugate()
    if min(one.imag, other.imag) > 0 or max(one.imag, other.imag) < 0 or one.imag == other.imag:
        return math.inf
    at = one.real + (other.real - one.real) * one.imag / (one.imag - other.imag)
    return at if at >= 0 else math.inf


def _closest(one: complex, other: complex) -> complex:
    """The point of a line that is closest to 0."""
    along = other - one
    length = abs(along) ** 2
    share = -(one * along.conjugate()).real / length if length else 0.0
    return one + along * min(max(share, 0.0), 1.0)


def _is_within(point: complex, width: float) -> bool:
    angle = cmath.phase(point) % _TURN
    return angle <= width + _ROUNDING or angle >= _TURN - _ROUNDING
