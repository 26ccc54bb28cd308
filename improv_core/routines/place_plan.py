"""Plans how robots get to their places without coming too near to each other: which drive next, and along which paths.

Lengths are in meters, angles in radians. Pure functions.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from improv_core.score.motion import Pose
from improv_core.score.obstacles import Obstacle, obstacles
from improv_core.score.world import World
from improv_core.slices import checkpoint

SLACK = 0.05
"""Room beyond the distance that robots should keep: they are slightly off their paths, and their poses arrive late."""
THERE, THERE_TURN = 0.04, math.radians(4)
"""The distance and the angle from its place within which a robot has arrived. The promise is slightly larger, 0.05 m
and 5°, because poses jitter."""
PROMISED, PROMISED_TURN = 0.05, math.radians(5)
ASIDE = (0.5, 1.0, 1.5, 2.0)
"""The distances that a robot drives to make room for others, or to get around an obstacle."""
DIRECTIONS = 16
"""The number of directions in which it may make room."""
MIN_SLACK = 1e-3
"""The tolerance for rounding by which a robot near another one may come nearer."""

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Traveler:
    """A robot: its pose, its place, its radius, and the distance that it may still move after a stop."""

    pose: Pose
    place: Pose
    radius: float
    coasting: float = 0.0

    @property
    def is_there(self) -> bool:
        return self.is_within(THERE, THERE_TURN)

    @property
    def is_as_promised(self) -> bool:
        return self.is_within(PROMISED, PROMISED_TURN)

    def is_within(self, distance: float, turn: float) -> bool:
        """Return whether it is near enough to its place."""
        far, turned = self.off
        return far <= distance and turned <= turn

    @property
    def off(self) -> tuple[float, float]:
        """Its distance from its place on the floor, and its angle from it."""
        far = math.dist(_point(self.pose), _point(self.place))
        return far, abs(math.remainder(self.pose.heading - self.place.heading, math.tau))


@dataclass(frozen=True, slots=True)
class DrivePath:
    """A path: the points to which a robot drives in turn, and the heading to which it then turns, if any. Without
    points, it only turns."""

    points: Sequence[Point]
    heading: float | None = None


@dataclass(frozen=True, slots=True)
class Plan:
    """The robots that can drive at the same time, and the obstacle of each robot that can't drive by itself."""

    paths: Mapping[str, DrivePath]
    blocked: Mapping[str, str] = field(default_factory=dict)


def next_paths(travelers: Mapping[str, Traveler], world: World) -> Plan:
    """Plan which robots drive next, while all others stand.

    A robot drives straight to its place, or around whatever stands between. A robot whose place blocks others lets them
    go first. If no robot can go, one makes room.
    """
    floor = _Floor(travelers, [*obstacles(world)], world)
    away = [robot for robot, each in travelers.items() if not each.is_there]
    free = {robot: path for robot in away if (path := floor.path(robot))}
    paths: dict[str, DrivePath] = {}
    hindered = {robot: floor.hindered(robot, away) for robot in free}
    for robot in sorted(free, key=lambda each: hindered[each]):
        if not paths or (not hindered[robot] and floor.are_apart(robot, free[robot], paths)):
            paths[robot] = free[robot]
    if away and not paths:
        paths = next(floor.paths_aside(away), {})
    return Plan(paths, {robot: floor.in_the_way(robot) for robot in away if robot not in free and not paths})


def too_near(travelers: Mapping[str, Traveler], keep_apart: float | None) -> list[tuple[str, str, float]]:
    """The pairs whose places are nearer to each other than real robots may be, with the distance between them."""
    names, found = [*travelers], []
    for number, one in enumerate(names):
        for other in names[:number]:
            mine, others = travelers[one], travelers[other]
            gap = math.dist(_point(mine.place), _point(others.place)) - mine.radius - others.radius
            if gap < (keep_apart or 0.0):
                found.append((other, one, max(gap, 0.0)))
    return found


@dataclass(frozen=True, slots=True)
class _Floor:
    """The positions of all robots, and everything to keep clear of."""

    travelers: Mapping[str, Traveler]
    things: Sequence[Obstacle]
    world: World

    def path(self, robot: str) -> DrivePath | None:
        """The path of a robot to its place while all others stand; None if there is none."""
        checkpoint()
        traveler = self.travelers[robot]
        if traveler.off[0] <= THERE:
            return DrivePath((), traveler.place.heading)
        begin, end = _point(traveler.pose), _point(traveler.place)
        for points in ([end], *([via, end] for via in _detours(begin, end))):
            if self._blocker(robot, points) is None:
                return DrivePath(points, traveler.place.heading)
        return None

    def in_the_way(self, robot: str) -> str:
        """The obstacle on the straight path of a robot that has no other path."""
        return self._blocker(robot, [_point(self.travelers[robot].place)]) or robot

    def hindered(self, robot: str, away: Collection[str]) -> int:
        """The number of robots whose straight paths this robot's place blocks."""
        return sum(other != robot and self._blocks(robot, _point(self.travelers[robot].place), other) for other in away)

    def are_apart(self, robot: str, path: DrivePath, others: Mapping[str, DrivePath]) -> bool:
        """Return whether a robot on this path keeps apart from all robots that drive at the same time."""
        mine = self._legs(robot, path.points)
        return all(
            _between(one, two) >= self._needed(robot, other, self.travelers[other].coasting)
            for other, each in others.items()
            for one in mine
            for two in self._legs(other, each.points)
        )

    def paths_aside(self, away: Collection[str]) -> Iterator[dict[str, DrivePath]]:
        """Paths on which one of the robots that are away makes room for another."""
        for robot in away:
            x, y = begin = _point(self.travelers[robot].pose)
            if not any(other != robot and self._blocks(robot, begin, other) for other in away):
                continue
            for far in ASIDE:
                for number in range(DIRECTIONS):
                    checkpoint()
                    angle = number * math.tau / DIRECTIONS
                    point = x + far * math.cos(angle), y + far * math.sin(angle)
                    is_out = all(other == robot or not self._blocks(robot, point, other) for other in away)
                    if is_out and self._blocker(robot, [point]) is None:
                        yield {robot: DrivePath([point])}

    def _blocks(self, robot: str, point: Point, other: str) -> bool:
        """Return whether a robot at a point blocks another one's straight path to its place."""
        traveler = self.travelers[other]
        leg = _point(traveler.pose), _point(traveler.place)
        return _between((point, point), leg) < self._needed(other, robot)

    def _blocker(self, robot: str, points: Sequence[Point]) -> str | None:
        """The first robot or thing in the world that a robot would come too near to on its path, if any.

        It may begin too near and drive away. It may end as near to a robot in its place as the program has them.
        """
        traveler, legs = self.travelers[robot], self._legs(robot, points)
        begin, end = legs[0][0], legs[-1][1]
        is_place = end == _point(traveler.place)
        for other, standing in self.travelers.items():
            if other != robot:
                spot = _point(standing.pose)
                enough = min(self._needed(robot, other), math.dist(begin, spot) - MIN_SLACK)
                if is_place and standing.is_as_promised:
                    least = traveler.radius + standing.radius + (self.world.keep_apart or 0.0)
                    enough = min(enough, max(math.dist(end, spot) - MIN_SLACK, least))
                if any(_between((spot, spot), leg) < enough for leg in legs):
                    return other
        return next((thing.name for thing in self.things if self._is_hit(traveler.radius, legs, thing)), None)

    def _is_hit(self, radius: float, legs: Sequence[tuple[Point, Point]], thing: Obstacle) -> bool:
        begin, end = (thing.distance(*point)[0] for point in (legs[0][0], legs[-1][1]))
        enough = min(radius + self.world.margin + SLACK, begin - MIN_SLACK, max(end - MIN_SLACK, radius))
        return any(_least(thing, leg) < enough for leg in legs)

    def _needed(self, robot: str, other: str, coasting: float = 0.0) -> float:
        """The distance from center to center that a driving robot must keep from another one, or both would be paused.
        The other one stands, unless its own `coasting` is given."""
        mine, others = self.travelers[robot], self.travelers[other]
        keeps = self.world.keep_apart + mine.coasting + coasting if self.world.keep_apart is not None else 0.0
        return mine.radius + others.radius + max(self.world.margin, keeps) + SLACK

    def _legs(self, robot: str, points: Sequence[Point]) -> list[tuple[Point, Point]]:
        begin = _point(self.travelers[robot].pose)
        return [*pairwise([begin, *points])] or [(begin, begin)]


def _detours(begin: Point, end: Point) -> Iterable[Point]:
    """Points beside a straight path, the nearest first."""
    (x, y), length = begin, math.dist(begin, end)
    along = (end[0] - x) / length, (end[1] - y) / length
    return [
        (x + share * length * along[0] - aside * along[1], y + share * length * along[1] + aside * along[0])
        for far in ASIDE
        for aside in (far, -far)
        for share in (0.5, 0.25, 0.75)
    ]


def _point(pose: Pose) -> Point:
    return pose.x, pose.y


def _between(one: tuple[Point, Point], other: tuple[Point, Point]) -> float:
    """The distance between two segments on the floor."""
    if one[0] != one[1] and other[0] != other[1] and _cross(one, other):
        return 0.0
    ends = [*((point, other) for point in one), *((point, one) for point in other)]
    return min(_to_segment(point, segment) for point, segment in ends)


def _cross(one: tuple[Point, Point], other: tuple[Point, Point]) -> bool:
    return _side(one, other[0]) * _side(one, other[1]) < 0 and _side(other, one[0]) * _side(other, one[1]) < 0


def _side(segment: tuple[Point, Point], point: Point) -> float:
    (x, y), (to_x, to_y) = segment
    return (to_x - x) * (point[1] - y) - (to_y - y) * (point[0] - x)


def _to_segment(point: Point, segment: tuple[Point, Point]) -> float:
    (x, y), (to_x, to_y) = segment
    length_x, length_y = to_x - x, to_y - y
    square = length_x * length_x + length_y * length_y
    share = ((point[0] - x) * length_x + (point[1] - y) * length_y) / square if square else 0.0
    share = min(max(share, 0.0), 1.0)
    return math.hypot(point[0] - x - share * length_x, point[1] - y - share * length_y)


def _least(thing: Obstacle, leg: tuple[Point, Point]) -> float:
    """The smallest distance between a leg and a thing. It is convex along the leg, so the farther third is cut off each
    time."""
    (x, y), (to_x, to_y) = leg

    def distance(share: float) -> float:
        return thing.distance(x + share * (to_x - x), y + share * (to_y - y))[0]

    low, high = 0.0, 1.0
    for _ in range(40):
        one, other = low + (high - low) / 3, high - (high - low) / 3
        low, high = (low, other) if distance(one) <= distance(other) else (one, high)
    return min(map(distance, (0.0, low, 1.0)))
