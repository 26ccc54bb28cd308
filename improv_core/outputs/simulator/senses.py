"""Senses of simulated robots: bumps, nearby things, and values of the declared sensors. Standard library only."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from functools import cached_property
from typing import NamedTuple

from improv_core.outputs.simulator.collisions import OVERLAP
from improv_core.outputs.simulator.robot import SimulatedRobot
from improv_core.outputs.simulator.sight import Scene, is_in_the_way, nearest, scene
from improv_core.protocol.output import Edge
from improv_core.score.senses import BUMP, CUE, NEAR, ODOMETRY, SECTORS, Key, RobotSense, Source, Topic
from improv_core.score.world import World


class _Nearby(NamedTuple):
    """The things and the robots that a robot could sense until the next search."""

    things: Scene
    robots: tuple[str, ...]


_NOTHING = _Nearby(Scene(), ())


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
        """The changes since the last call."""
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
