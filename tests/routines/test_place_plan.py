"""Plans for robots that drive to their places: from their poses and places to the paths of those that can drive."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from itertools import combinations

import pytest

from improv_core.routines.place_plan import SLACK, THERE, Plan, Point, Traveler, next_paths, too_near
from improv_core.score.motion import Pose
from improv_core.score.world import Box, Circle, Wall, World

RADIUS = 0.1
MARGIN = 0.1
FREE = World(margin=MARGIN)
NEEDED = 2 * RADIUS + MARGIN


def going(*ends: Point, heading: float = 0.0) -> Traveler:
    """A robot on its way from one point to another."""
    return Traveler(Pose(*ends[0]), Pose(*ends[-1], heading=heading), RADIUS)


def standing(x: float, y: float) -> Traveler:
    return going((x, y))


def driven(travelers: dict[str, Traveler], plan: Plan) -> dict[str, Traveler]:
    """The robots after they have driven their paths."""
    moved = dict(travelers)
    for robot, path in plan.paths.items():
        before = travelers[robot]
        x, y = path.points[-1] if path.points else (before.pose.x, before.pose.y)
        heading = before.pose.heading if path.heading is None else path.heading
        moved[robot] = replace(before, pose=Pose(x, y, heading=heading))
    return moved


def check(travelers: dict[str, Traveler], rounds: list[str], blocked: str = "", world: World = FREE) -> None:
    """Check which robots drive in each round, and what blocks the others in the end."""
    found = []
    while (plan := next_paths(travelers, world)).paths:
        found.append(" ".join(sorted(plan.paths)))
        travelers = driven(travelers, plan)
    assert (found, " ".join(f"{robot}<{thing}" for robot, thing in plan.blocked.items())) == (rounds, blocked)


def test_robots_drive_together_or_one_after_another() -> None:
    check({"a": going((0, 0), (2, 0)), "b": going((0, 1), (2, 1))}, ["a b"])
    check({"a": going((0, 0), (2, 2)), "b": going((0, 2), (2, 0))}, ["a", "b"])
    check({"a": going((0, 1), (1, 0)), "b": going((0, 0), (3, 0))}, ["b", "a"])
    check({"a": going((0, 0), (1, 0)), "b": going((1, 0), (2, 0))}, ["b", "a"])
    check({"a": going((0, 0), (2, 0)), "b": going((2, 0), (0, 0))}, ["a", "b", "a"])


def test_a_robot_in_its_place_stays_or_only_turns() -> None:
    travelers = {"a": going((0, 0), (THERE / 2, 0)), "b": going((1, 0), (1, 0), heading=1.0)}
    plan = next_paths(travelers, FREE)
    assert {robot: ([*path.points], path.heading) for robot, path in plan.paths.items()} == {"b": ([], 1.0)}


def test_a_robot_drives_around_one_that_stands_in_its_way() -> None:
    plan = next_paths({"a": going((0, 0), (2, 0)), "b": standing(1, 0)}, FREE)
    via, end = plan.paths["a"].points
    assert end == (2, 0)
    assert math.dist(via, (1, 0)) >= NEEDED


@pytest.mark.parametrize(
    ("world", "thing"),
    [
        (World(walls=(Wall(1, -9, 1, 9),), margin=MARGIN), "wall 1"),
        (World(boxes=(Box(1, 0, 0.5, 18),), margin=MARGIN), "box 1"),
        (World(circles=(Circle(2.1, 0, 0.5),), margin=MARGIN), "circle 1"),  # its place is inside
    ],
)
def test_a_robot_without_a_way_is_blocked_by_what_is_in_it(world: World, thing: str) -> None:
    check({"a": going((0, 0), (2, 0))}, [], f"a<{thing}", world)


@pytest.mark.parametrize(("coasting", "together"), [(0.0, ["a", "b"]), (0.06, ["a"])])
def test_robots_that_would_be_paused_beside_each_other_drive_one_after_another(
    coasting: float, together: list[str]
) -> None:
    """Beyond the distance that they keep, 0.1 m is left between them, and each may still come 0.06 m nearer."""
    beside = 2 * RADIUS + 0.3 + SLACK + 0.1
    travelers = {"a": going((0, 0), (2, 0)), "b": going((0, beside), (2, beside))}
    travelers = {robot: replace(each, coasting=coasting) for robot, each in travelers.items()}
    assert [*next_paths(travelers, World(keep_apart=0.3)).paths] == together


def test_robots_that_begin_or_end_near_each_other_still_drive() -> None:
    check({"a": going((0, 0), (-1, 0)), "b": going((0.21, 0), (1, 0))}, ["a", "b"])
    check({"a": going((0, 0), (2, 0)), "b": standing(2.25, 0)}, ["a"])
    check({"a": going((0, 0), (2, 0)), "b": standing(2.1, 0)}, [], "a<b")


def test_places_nearer_than_real_robots_may_be_are_found() -> None:
    travelers = {"a": standing(0, 0), "b": standing(0.4, 0), "c": standing(3, 0)}
    assert [(one, other, round(gap, 6)) for one, other, gap in too_near(travelers, 0.3)] == [("a", "b", 0.2)]
    assert too_near(travelers, None) == []


@pytest.mark.parametrize("seed", range(12))
def test_scattered_robots_keep_apart_all_the_way(seed: int) -> None:
    lots, points = random.Random(seed), list[Point]()
    while len(points) < 8:
        point = lots.uniform(-3, 4), lots.uniform(-3, 4)
        if all(math.dist(point, other) > 0.5 for other in points):
            points.append(point)
    travelers = {f"r{number}": going(point, (number % 3, number // 3)) for number, point in enumerate(points)}
    for _ in range(40):
        plan = next_paths(travelers, FREE)
        for one, other in combinations(travelers, 2):
            for mine in _along(travelers[one], plan, one):
                for others in _along(travelers[other], plan, other):
                    assert math.dist(mine, others) >= NEEDED + SLACK - 0.04
        if not plan.paths:
            break
        travelers = driven(travelers, plan)
    assert plan.blocked == {}
    assert all(each.is_there for each in travelers.values())


def _along(traveler: Traveler, plan: Plan, robot: str) -> list[Point]:
    """Points along the path of a robot, at most 4 cm apart."""
    found = [(traveler.pose.x, traveler.pose.y)]
    for to in plan.paths[robot].points if robot in plan.paths else ():
        (x, y), steps = found[-1], math.ceil(math.dist(found[-1], to) / 0.04)
        found += [(x + (to[0] - x) * step / steps, y + (to[1] - y) * step / steps) for step in range(1, steps + 1)]
    return found
