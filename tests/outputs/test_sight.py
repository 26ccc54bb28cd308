"""Obstacles in a robot's way and the distances a sensor would measure: some cases, and any scene compared with small
steps."""

from __future__ import annotations

import cmath
import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from improv_core.outputs.simulator.senses import Scene, is_in_the_way, nearest, scene
from improv_core.score.motion import Pose
from improv_core.score.world import Box, Circle, Wall, World

RADIUS, REACH = 0.3, 1.0
ALL_AROUND = (-math.pi, math.pi)


@pytest.mark.parametrize(
    ("world", "expected"),
    [
        (World(walls=(Wall(-9, 0.31, 9, 0.31),)), False),
        (World(walls=(Wall(-9, 0.29, 9, 0.29),)), False),
        (World(walls=(Wall(0.5, 0.29, 9, 0.29),)), True),
        (World(walls=(Wall(0.5, 0.0, 0.6, 0.0),)), True),
        (World(boxes=(Box(1.5, 0, 0.5, 0.1),)), True),
        (World(boxes=(Box(1.5, 0, 0.5, 0.1, math.pi / 2),)), False),
        (World(size=(2.5, 9)), True),
        (World(size=(2.7, 9)), False),
    ],
)
@pytest.mark.parametrize("turn", [0.0, 1.0, math.pi])
def test_obstacles_in_the_way_are_found(world: World, expected: bool, turn: float) -> None:
    assert is_in_the_way(turned(scene(world), turn), Pose(heading=turn), RADIUS, REACH) is expected


@pytest.mark.parametrize(
    ("world", "sector", "expected"),
    [
        (World(walls=(Wall(2, -1, 2, 1),)), ALL_AROUND, 2.0),
        (World(walls=(Wall(2, 1, 2, 3),)), ALL_AROUND, math.sqrt(5)),
        (World(walls=(Wall(2, 1, 2, 3),)), (0.0, 0.0), math.inf),
        (World(walls=(Wall(2, -1, 2, 3),)), (0.0, 0.0), 2.0),
        (World(walls=(Wall(2, -9, 2, 9),)), (math.pi / 4, math.pi / 3), 2 * math.sqrt(2)),
        (World(walls=(Wall(2, -9, 2, 9),)), (math.pi / 2 + 0.1, math.pi), math.inf),
        (World(circles=(Circle(2, 0, 0.5),)), ALL_AROUND, 1.5),
        (World(circles=(Circle(2, 0, 0.5),)), (math.pi / 2, 3 * math.pi / 2), math.inf),
        (World(circles=(Circle(-2, 0, 0.5),)), (math.pi / 2, 3 * math.pi / 2), 1.5),
        (World(circles=(Circle(0.1, 0, 0.5),)), (3.0, 3.1), 0.0),
        (World(boxes=(Box(2, 0, 1, 1),)), (0.0, 0.0), 1.5),
        (World(boxes=(Box(2, 0, 1, 1, math.pi / 4),)), ALL_AROUND, 2 - math.sqrt(0.5)),
        (World(), ALL_AROUND, math.inf),
    ],
)
@pytest.mark.parametrize("turn", [0.0, 1.0, math.pi])
def test_the_nearest_thing_in_a_sector_is_found(
    world: World, sector: tuple[float, float], expected: float, turn: float
) -> None:
    assert nearest(turned(scene(world), turn), Pose(heading=turn), *sector) == pytest.approx(expected)


places = st.floats(-3, 3).map(lambda value: round(value, 3))
scenes = st.builds(
    World,
    walls=st.lists(st.builds(Wall, places, places, places, places), max_size=3).map(tuple),
    circles=st.lists(st.builds(Circle, places, places, st.floats(0.05, 1)), max_size=2).map(tuple),
).map(scene)
poses = st.builds(Pose, places, places, heading=st.floats(-7, 7))


def test_a_wall_behind_does_not_block_a_robot_that_has_hardly_turned() -> None:
    things = scene(World(walls=(Wall(-1, 0, -2, 0),)))
    assert not is_in_the_way(things, Pose(heading=1e-233), RADIUS, REACH)


@pytest.mark.slow("compares one look with many")
@given(scenes, poses)
def test_any_path_agrees_with_many_small_steps(things: Scene, pose: Pose) -> None:
    """If nothing touches the disc at first, it is stopped if a disc that moves along the path would touch something."""
    if distance(things, complex(pose.x, pose.y)) <= RADIUS:
        return
    steps = [complex(pose.x, pose.y) + cmath.rect(REACH * step / 100, pose.heading) for step in range(101)]
    least = min(distance(things, step) for step in steps)
    if abs(least - RADIUS) > REACH / 100:
        assert is_in_the_way(things, pose, RADIUS, REACH) is (least < RADIUS)


@given(scenes, poses, st.floats(-math.pi, math.pi), st.floats(0, 2 * math.pi))
def test_any_sector_agrees_with_many_rays(things: Scene, pose: Pose, start: float, width: float) -> None:
    place = complex(pose.x, pose.y)
    # Exactly on the edge of a disc, rounding decides if a ray that leads away from it touches it.
    assume(all(abs(abs(center - place) - radius) > 1e-9 for center, radius in things.discs))
    # Exactly on a line, rounding decides on which side of it a robot stands.
    assume(nearest(things, pose, *ALL_AROUND) > 1e-9)
    found = nearest(things, pose, start, start + width)
    rays = [nearest(things, pose, angle, angle) for angle in (start + width * ray / 200 for ray in range(201))]
    assert found <= min(rays) + 1e-9
    assert found >= distance(things, complex(pose.x, pose.y)) - 0.02
    if width > 6.283 and found < math.inf:
        assert found == pytest.approx(distance(things, complex(pose.x, pose.y)), abs=0.02)


def distance(things: Scene, place: complex) -> float:
    """The distance from a place to the nearest thing in any direction, computed in small steps along each line."""
    lines = (abs(one + (other - one) * step / 400 - place) for one, other in things.lines for step in range(401))
    discs = (max(abs(center - place) - radius, 0.0) for center, radius in things.discs)
    return min([*lines, *discs], default=math.inf)


def turned(things: Scene, angle: float) -> Scene:
    turn = cmath.rect(1, angle)
    lines = tuple((one * turn, other * turn) for one, other in things.lines)
    return Scene(lines, tuple((center * turn, radius) for center, radius in things.discs))
