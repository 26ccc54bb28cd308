"""Start poses of robots that nobody has placed: in rows, and inside the walls if there are some."""

from __future__ import annotations

import math
from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.motion import Pose


def starts(toml: str, robots: int) -> list[tuple[float, float]]:
    """Return the starts of the robots r0, r1, ..."""
    names = " ".join(f"r{number}" for number in range(robots))
    score = score_of(analyze(f"{names} $ forward", read_robots(toml)))
    poses = [part.start for part in score.parts.values()]
    assert poses == [Pose(pose.x, pose.y) for pose in poses]
    return [(pose.x, pose.y) for pose in poses]


ROWS = [(-3.0 * behind, -3.0 * beside) for behind in range(3) for beside in range(8)]


@pytest.mark.parametrize("toml", ["", "[world]\ncircles = [{ x = 1, radius = 0.3 }]", "[world]\nsize = [60, 50]"])
def test_robots_stand_in_rows_of_eight(toml: str) -> None:
    assert starts(toml, 20) == ROWS[:20]


@pytest.mark.parametrize(
    ("size", "robots", "expected"),
    [
        ("[6, 4]", 1, [(0, 0)]),
        ("[6, 4]", 3, [(1.5, 1), (1.5, -1), (-1.5, 1)]),
        ("[20, 20]", 4, ROWS[:4]),
        ("[20, 20]", 5, [(0, 6), (0, 3), (0, 0), (0, -3), (0, -6)]),
        ("[3, 1.4]", 4, [(1.125, 0), (0.375, 0), (-0.375, 0), (-1.125, 0)]),
    ],
)
def test_inside_walls_they_stand_as_far_apart_as_there_is_room(
    size: str, robots: int, expected: list[tuple[float, float]]
) -> None:
    assert starts(f"[world]\nsize = {size}", robots) == [pytest.approx(place) for place in expected]


def test_they_keep_clear_of_those_with_a_start() -> None:
    robots = "[robots.r0]\nstart = { y = -2.9 }\n[robots.r1]\n[robots.r2]\nstart = { x = 1.4, y = 1.1 }\n[robots.r3]"
    placed = starts(f"[world]\nsize = [8, 7]\n{robots}", 4)
    assert placed[0] == (0, -2.9)
    assert all(math.dist(one, other) >= 0.6 for one, other in combinations(placed, 2))
    assert all(abs(x) <= 3.7 and abs(y) <= 3.2 for x, y in placed)


@given(st.floats(0.7, 50), st.floats(0.7, 50), st.integers(1, 60))
def test_nobody_is_outside_and_nobody_overlaps_where_there_is_room(width: float, depth: float, robots: int) -> None:
    placed = starts(f"[world]\nsize = [{width}, {depth}]", robots)
    assert all(abs(x) < width / 2 and abs(y) < depth / 2 for x, y in placed)
    if math.floor(width / 0.6) * math.floor(depth / 0.6) >= robots:
        assert all(abs(x) <= width / 2 - 0.299 and abs(y) <= depth / 2 - 0.299 for x, y in placed)
        assert all(math.dist(one, other) > 0.599 for one, other in combinations(placed, 2))


def test_a_full_floor_is_not_searched_forever() -> None:
    toml = """
        [world]
        size = [100, 100]
        [profiles.big]
        radius = 80
        [profiles.small]
        radius = 0.001
        [robots.r0]
        profile = "big"
        start = {}
        [robots.r1]
        profile = "small"
    """
    assert starts(toml, 2) == [(0, 0), (0, 0)]
