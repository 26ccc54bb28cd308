"""Collisions of simulated robots with each other, walls, and obstacles: pushes and bumps (pymunk)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from improv_core.protocol.drawn import Bump
from improv_core.score.approach import TOLERANCE
from improv_core.score.dynamics import STEPS_PER_SECOND
from improv_core.score.motion import Pose
from improv_core.score.world import EMPTY, World

if TYPE_CHECKING:
    import pymunk

OVERLAP = TOLERANCE
"""Meters by which two robots overlap before they push each other, and while they do: neighbors who touch don't meet.
pymunk needs some overlap to keep the contact."""
STEP = 1 / STEPS_PER_SECOND
"""The length of a step in seconds, for pymunk."""
BUMP = 0.01
"""m/s. Robots that approach more slowly lean on each other but do not bump."""
APART = 0.5
"""Seconds without contact after which touching again counts as a new bump."""
GRIP = 0.6
"""Friction of bases with motors, about that of rubber on a floor. Ideal robots have none, so no push turns them."""


class Disc(NamedTuple):
    """The shape of a robot: its radius in meters, which is also half its height, and whether it has grip."""

    radius: float
    grips: bool


@dataclass(frozen=True, slots=True)
class Pushed:
    """A robot's pose after a step in which it was pushed, and its velocity in the world frame, in m/s and rad/s."""

    pose: Pose
    x: float
    y: float
    yaw: float


class NoCollisions:
    """The robots in a world that are near something, if nothing computes collisions: they pass through everything."""

    def __init__(self, world: World) -> None:
        """Ignore the world."""

    def near_obstacle(self, x: float, y: float, reach: float) -> bool:
        """Return whether a wall or an obstacle is within `reach` meters of a point."""
        return False

    def keep(self, discs: Mapping[str, Disc]) -> None:
        """Add these robots and remove all others."""

    def push(self, paths: Mapping[str, tuple[Pose, Pose]], start: float, end: float) -> dict[str, Pushed]:
        """Move the robots along their paths, from their poses at `start` to where they want to be at `end`.

        Returns those that were pushed.
        """
        return {}

    def take_bumps(self) -> list[Bump]:
        return []

    def take_contacts(self) -> tuple[set[str], set[str]]:
        """The robots that bumped or were bumped into, and those that touched anything, since the last call."""
        return set(), set()


class Collisions(NoCollisions):
    """Collisions computed by pymunk."""

    def __init__(self, world: World) -> None:
        import pymunk

        self._space = pymunk.Space()
        self._space.collision_slop = OVERLAP
        self._space.on_collision(pre_solve=self._touch)
        self._empty = world == EMPTY
        self._things = self._add_obstacles(world)
        self._bodies: dict[str, tuple[pymunk.Body, pymunk.Circle, Disc]] = {}
        self._names: dict[pymunk.Shape, str] = {}  # of robots
        self._paths: Mapping[str, tuple[Pose, Pose]] = {}
        self._touched: dict[tuple[str, ...], float] = {}  # when each pair that has bumped touched last
        self._above: dict[tuple[str, ...], float] = {}  # when one robot of a pair was last above the other
        self._start = self._end = 0.0
        self._bumps: list[Bump] = []
        self._pressed: set[str] = set()
        self._touching: set[str] = set()

    def near_obstacle(self, x: float, y: float, reach: float) -> bool:
        import pymunk

        if self._empty:
            return False
        return self._space.point_query_nearest((x, y), reach, pymunk.ShapeFilter(mask=_OBSTACLES)) is not None

    def keep(self, discs: Mapping[str, Disc]) -> None:
        for name in [name for name, (*_, disc) in self._bodies.items() if discs.get(name) != disc]:
            body, shape, _ = self._bodies.pop(name)
            del self._names[shape]
            self._space.remove(shape, body)
        for name, disc in discs.items():
            if name not in self._bodies:
                self._bodies[name] = self._add_robot(name, disc)

    def push(self, paths: Mapping[str, tuple[Pose, Pose]], start: float, end: float) -> dict[str, Pushed]:
        # pymunk always gets steps of the same length, with slower robots in shorter ones. Otherwise it would scale the
        # impulses of the previous step by the ratio of the lengths and throw robots apart.
        real = STEP / (end - start)
        self._paths, self._start, self._end = paths, start, end
        wanted = {}
        for name, (before, after) in paths.items():
            body, *_ = self._bodies[name]
            velocity = ((after.x - before.x) / STEP, (after.y - before.y) / STEP)
            yaw = (after.heading - before.heading) / STEP
            body.position, body.angle = (before.x, before.y), before.heading
            body.velocity, body.angular_velocity = velocity, yaw
            wanted[name] = (*velocity, yaw)
        self._space.step(STEP)
        pushed = {}
        for name, (_, after) in paths.items():
            body, *_ = self._bodies[name]
            body.update_position(body, STEP)
            velocity, yaw = body.velocity, body.angular_velocity
            if (*velocity, yaw) != wanted[name] or math.dist(body.position, (after.x, after.y)) > _ROUNDING:
                pose = Pose(*body.position, after.z, body.angle)
                pushed[name] = Pushed(pose, velocity.x * real, velocity.y * real, yaw * real)
        return pushed

    def take_bumps(self) -> list[Bump]:
        bumps, self._bumps = self._bumps, []
        return bumps

    def take_contacts(self) -> tuple[set[str], set[str]]:
        contacts = self._pressed, self._touching
        self._pressed, self._touching = set(), set()
        return contacts

    def _add_obstacles(self, world: World) -> dict[pymunk.Shape, str]:
        """Add what no robot can move. Return what each is, in words."""
        import pymunk

        ground = self._space.static_body
        things: dict[pymunk.Shape, str] = {}
        for number, (x1, y1, x2, y2) in enumerate(world.all_walls()):
            kind = "a wall" if number < len(world.walls) else "the edge of the floor"
            things[pymunk.Segment(ground, (x1, y1), (x2, y2), 0.0)] = kind
        things |= {pymunk.Circle(ground, radius, (x, y)): "an obstacle" for x, y, radius in world.circles}
        for x, y, width, height, heading in world.boxes:
            turned = pymunk.Transform.translation(x, y).rotated(heading)
            corners = [(sx * width / 2, sy * height / 2) for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            things[pymunk.Poly(ground, corners, turned)] = "an obstacle"
        for shape in things:
            shape.friction = 1.0  # only the grip of the robot that touches it matters
            shape.filter = pymunk.ShapeFilter(categories=_OBSTACLES)
        self._space.add(*things)
        return things

    def _add_robot(self, name: str, disc: Disc) -> tuple[pymunk.Body, pymunk.Circle, Disc]:
        import pymunk

        body = pymunk.Body(mass=1.0, moment=pymunk.moment_for_circle(1.0, 0.0, disc.radius))
        # pymunk moves bodies first and then solves contacts. `push` moves them afterward instead, so pymunk solves the
        # velocities before they are used, and no robot drives into another that blocks it.
        body.position_func = _stay
        shape = pymunk.Circle(body, disc.radius)  # no bounce
        shape.friction = GRIP if disc.grips else 0.0
        shape.filter = pymunk.ShapeFilter(categories=_ROBOTS)
        self._space.add(body, shape)
        self._names[shape] = name
        return body, shape, disc

    def _touch(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        """pymunk calls this for every pair that touches, before they push each other."""
        names = tuple(sorted(self._names[shape] for shape in arbiter.shapes if shape in self._names))
        (contact,) = arbiter.contact_point_set.points
        least = min(OVERLAP, *(self._bodies[name][2].radius / 10 for name in names))
        if arbiter.is_first_contact or not arbiter.process_collision:  # pymunk keeps this until the two separate
            arbiter.process_collision = contact.distance < -least
        if not arbiter.process_collision:
            return
        if len(names) == 2 and self._is_above(*names):
            arbiter.process_collision = False
            self._above[names] = self._end
            return
        closing = _closing(arbiter) * STEP / (self._end - self._start)
        if self._above.get(names) == self._start:
            closing = max(closing, self._sinking(*names))
        self._touching.update(names)
        if closing > BUMP:
            self._pressed.update(names)
        if self._end - self._touched.get(names, -math.inf) <= APART:
            self._touched[names] = self._end
        elif closing > BUMP:
            self._touched[names] = self._end
            thing = next((self._things[shape] for shape in arbiter.shapes if shape in self._things), "")
            self._bumps.append(Bump(self._end, contact.point_a.x, contact.point_a.y, names, thing))

    def _is_above(self, one: str, other: str) -> bool:
        (*_, disc), (*_, beside) = self._bodies[one], self._bodies[other]
        return abs(self._paths[one][0].z - self._paths[other][0].z) >= disc.radius + beside.radius

    def _sinking(self, one: str, other: str) -> float:
        """Return the speed at which the upper robot sinks toward the lower one."""
        (before, after), (below, later) = self._paths[one], self._paths[other]
        return (abs(before.z - below.z) - abs(after.z - later.z)) / (self._end - self._start)


class Touches(Collisions):
    """Collisions that push nobody: robots notice them, and stay on their paths."""

    def push(self, paths: Mapping[str, tuple[Pose, Pose]], start: float, end: float) -> dict[str, Pushed]:
        super().push(paths, start, end)
        return {}


def touches(world: World) -> NoCollisions:
    """Return what notices touches, and pushes nobody; in a browser, which has no pymunk, it notices none."""
    try:
        return Touches(world)
    except ImportError:
        return NoCollisions(world)


_ROBOTS, _OBSTACLES = 1, 2
_ROUNDING = 1e-9


def _closing(arbiter: pymunk.Arbiter) -> float:
    """Return the speed at which two touching shapes approach each other, in pymunk's time."""
    one, other = (shape.body.velocity for shape in arbiter.shapes if shape.body)
    return float((one - other).dot(arbiter.normal))


def _stay(body: pymunk.Body, dt: float) -> None:
    """A position function that leaves the body where it is."""
