"""Robots in formation: their places, robots with their own starts, and errors in formations."""

from __future__ import annotations

import math

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from tests.robots.drawing import check

LISTED = "".join(f"[robots.{name}]\n" for name in "abcd")


def starts(toml: str, robots: str = "a b c d") -> list[tuple[float, float, float]]:
    """Return the starts of a program's robots, in meters and degrees."""
    score = score_of(analyze(f"{robots} $ forward", read_robots(toml)))
    poses = (part.start for part in score.parts.values())
    return [(round(pose.x, 3), round(pose.y, 3), round(math.degrees(pose.heading), 3) % 360) for pose in poses]


def stand(toml: str, *expected: tuple[float, float, float]) -> None:
    """Compare the places of four robots, listed or not."""
    assert starts(toml) == starts(f"{LISTED}{toml}") == [*expected]


def test_shapes_stand_around_the_origin() -> None:
    stand("[formation]\nshape='line'\ndistance=2", (0, 3, 0), (0, 1, 0), (0, -1, 0), (0, -3, 0))
    stand("[formation]\nshape='grid'", (1.5, 1.5, 0), (1.5, -1.5, 0), (-1.5, 1.5, 0), (-1.5, -1.5, 0))
    for shape in ("line", "circle", "grid"):
        assert starts(f"[formation]\nshape='{shape}'", "a") == [(0, 0, 0)]


def test_a_circle_looks_in_or_out() -> None:
    circle = "[formation]\nshape='circle'\ndistance=2\n"
    far = 1.414
    stand(circle, (0, far, 270), (-far, 0, 0), (0, -far, 90), (far, 0, 180))
    stand(f"{circle}facing='out'", (0, far, 90), (-far, 0, 180), (0, -far, 270), (far, 0, 0))


@pytest.mark.parametrize("count", [2, 3, 7, 50])
def test_neighbors_on_a_circle_are_the_distance_apart(count: int) -> None:
    poses = starts("[formation]\nshape='circle'\ndistance=1.5", " ".join(f"r{number}" for number in range(count)))
    apart = [math.dist(one[:2], other[:2]) for one, other in zip(poses, [*poses[1:], poses[0]], strict=True)]
    assert apart == pytest.approx([1.5] * count, abs=0.005)


def test_a_robot_with_a_start_keeps_it_and_the_others_close_up() -> None:
    toml = "[formation]\nshape='line'\n[robots.a]\n[robots.b]\nstart={x=9,heading=45}\n[robots.c]\n"
    assert starts(toml, "a b c") == [(0, 1.5, 0), (9, 0, 45), (0, -1.5, 0)]


def test_listed_robots_keep_their_places_with_any_dancers() -> None:
    assert starts(f"[formation]\nshape='line'\ndistance=2\n{LISTED}", "d b") == [(0, -3, 0), (0, 1, 0)]


def test_robots_of_a_program_stay_inside_the_walls() -> None:
    toml = "[formation]\nshape='line'\n[world]\nsize=[6,6]"
    assert starts(toml, "a b") == [(0, 1.5, 0), (0, -1.5, 0)]
    assert all(abs(x) < 3 and abs(y) < 3 for x, y, _ in starts(toml))


def test_errors_in_a_formation_are_marked() -> None:
    check("""
        [formation]
         ^^^^^^^^^ robots: add `shape`: `line`, `circle`, `grid`
        distance = 2
    """)
    check("""
        [formation]
        shape = "line"
        facing = "out"
        ^^^^^^ robots: `facing` works only with `shape = "circle"`: remove it
    """)


def test_robots_that_would_overlap_or_stand_outside() -> None:
    check("""
        [formation]
        shape = "grid"
        distance = 0.5
                   ^^^ robots: `big` is 0.99 m wide: make the distance at least that, so that no robots overlap
        [robots.small]
        [robots.big]
        profile = "husky"
    """)
    check("""
        [formation]
        shape = "line"
        distance = 4
                   ^ robots: 2 robots don't fit between the walls: make the distance shorter or the world larger
        [robots.a]
        [robots.b]
        [world]
        size = [4, 4]
    """)
