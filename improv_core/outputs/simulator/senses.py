"""Senses of simulated robots: bumps, nearby things, and values of the declared sensors, by what is in sight. Points are
complex numbers, in meters. Standard library only."""

from __future__ import annotations

import cmath
import math
from collections.abc import Collection, Mapping
from functools import cached_property
from typing import NamedTuple

from improv_core.outputs.simulator.collisions import OVERLAP
from improv_core.outputs.simulator.robot import SimulatedRobot
from improv_core.protocol.output import Edge
from improv_core.score.motion import Pose
from improv_core.score.senses import BUMP, CUE, NEAR, ODOMETRY, SECTORS, Key, RobotSense, Source, Topic
from improv_core.score.world import World


class _Nearby(NamedTuple):
    """The things and the robots that a robot could sense until the next search."""

    things: Scene
    robots: tuple[str, ...]


class SimulatedSenses:
    """Computes the senses that are read, and no others, and finds their changes."""

    def __init__(self, world: World, robots: Mapping[str, SimulatedRobot]) -> None:
        self._world = world
        self._robots = robots
        self._values: dict[RobotSense, bool] = {}  # the values of the senses that are read
        self._nearby: dict[RobotSense, _Nearby] = {}
        self._reach = 0.0
        self._jumped = False

    @cached_property
    def _scene(self) -> Scene:
        """Everything in the world. It is found when a sense needs it, since first velocities must not wait for it."""
        return scene(self._world)

    def ask(self, asked: Collection[RobotSense], at: float) -> list[Edge]:
        """Watch these senses, and return an edge for each one that wasn't watched before.

        Keys and cues are left out: they come from people.
        """
        ours = [each for each in sorted(asked) if each.sense != CUE and not isinstance(self._source(each), Key)]
        before = {each: self._values[each] for each in ours if each in self._values}
        kept = {} if self._jumped else before
        self._values = {each: kept[each] if each in kept else self._value(each, at) for each in ours}
        self._jumped = False
        return [Edge(each, value, at) for each, value in self._values.items() if before.get(each) != value]

    def jump(self) -> None:
        """Recompute everything: robots were moved by hand, or the world changed."""
        self._jumped = True
        self.look(0.0)

    def look(self, reach: float) -> None:
        """Forget what is near. Until the next call, robots move no farther than `reach` meters."""
        self._reach = reach
        self._nearby.clear()

    def could_change(self, at: float) -> bool:
        """Return whether a sense may change before the next `look` if no robots touch anything until then."""
        return any(self._measures_speed(each) or self._near(each, at) != _NOTHING for each in self._values)

    def changes(self, at: float) -> list[Edge]:
        values = {each: self._value(each, at) for each in self._values}
        edges = [Edge(each, value, at) for each, value in values.items() if self._values[each] != value]
        self._values = values
        return edges

    def _value(self, asked: RobotSense, at: float) -> bool:
        """The value of a sense; false if only a real sensor can know it."""
        robot, source = self._robots[asked.robot], self._source(asked)
        if isinstance(source, Topic) and self._measures_speed(asked):
            return source.compare(robot.speed_at(at))
        if isinstance(source, Topic) and source.message in SECTORS:
            sector = SECTORS[source.message] or (source.start, source.end)
            return source.compare(nearest(self._in_sight(asked, at), robot.pose_at(at), *sector))
        if asked.sense == NEAR:
            # A slightly slimmer disc slides along what it touches, and overlaps as far as it is pushed.
            slim = max(robot.disc.radius - 2 * OVERLAP, robot.disc.radius / 2)
            reach = robot.part.profile.reach + robot.disc.radius - slim
            return is_in_the_way(self._in_sight(asked, at), robot.pose_at(at), slim, reach)
        return asked.sense == BUMP and robot.bumped

    def _source(self, asked: RobotSense) -> Source | None:
        return self._robots[asked.robot].part.senses.get(asked.sense)

    def _measures_speed(self, asked: RobotSense) -> bool:
        source = self._source(asked)
        return isinstance(source, Topic) and source.message == ODOMETRY

    def _in_sight(self, asked: RobotSense, at: float) -> Scene:
        """Everything that a robot could sense, with the other robots where they are now."""
        things, robots = self._near(asked, at)
        if not robots:
            return things
        robot = self._robots[asked.robot]
        z, poses = robot.pose_at(at).z, {name: self._robots[name].pose_at(at) for name in robots}
        high = robot.disc.radius if asked.sense == NEAR else 0.0  # a scanner sees only things at its own height
        discs = [
            (complex(pose.x, pose.y), self._robots[name].disc.radius)
            for name, pose in poses.items()
            if abs(pose.z - z) < self._robots[name].disc.radius + high
        ]
        return Scene(things.lines, (*things.discs, *discs))

    def _near(self, asked: RobotSense, at: float) -> _Nearby:
        if asked not in self._nearby:
            self._nearby[asked] = self._find(asked, at)
        return self._nearby[asked]

    def _find(self, asked: RobotSense, at: float) -> _Nearby:
        robot, source = self._robots[asked.robot], self._source(asked)
        if isinstance(source, Topic) and source.message in SECTORS:
            far = source.below or source.above or 0.0
        elif asked.sense == NEAR:
            far = robot.part.profile.reach + robot.disc.radius
        else:
            return _NOTHING
        far += 2 * self._reach  # the robot moves, and others may come closer
        pose = robot.pose_at(at)
        here = complex(pose.x, pose.y)
        places = {name: other.pose_at(at) for name, other in self._robots.items() if other is not robot}
        others = tuple(
            name
            for name, place in places.items()
            if abs(complex(place.x, place.y) - here) <= far + self._robots[name].disc.radius
        )
        return _Nearby(self._scene.within(here, far), others)


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
        """The same things seen from a pose: that is the origin, and `direction` from its heading the real axis."""
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
    """Return whether a disc would touch something in its next `reach` meters ahead, except what it moves away from."""
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


_NOTHING = _Nearby(Scene(), ())
