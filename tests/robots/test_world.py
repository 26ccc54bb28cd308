"""The floor, walls, and boxes of `improv.toml`, and robots that start inside them."""

from __future__ import annotations

import math

from improv_core.score.world import Box, Circle, Wall, World
from tests.robots.drawing import check


def test_a_world_has_its_size_walls_circles_and_boxes() -> None:
    found = check("""
        [world]
        size = [6, 4]
        walls = [[-1, 0, 1, 0.5]]
        circles = [{ x = 1, radius = 0.3 }]
        [[world.boxes]]
        width = 1
        height = 0.5
        heading = 90
    """)
    assert found.world == World(
        (6, 4), (Wall(-1, 0, 1, 0.5),), (Circle(1, 0, 0.3),), (Box(0, 0, 1, 0.5, heading=math.pi / 2),)
    )


def test_robots_start_inside_the_walls() -> None:
    check("""
        [world]
        size = [6, 4]
        [robots.a]
        start = { x = 3, y = 2 }
        [robots.b]
        start = { x = 3.5 }
                ^^^^^^^^^^^ robots: this start is outside the walls: move it inside
    """)


def test_a_robot_that_is_wider_than_the_floor() -> None:
    check("""
        [world]
        size = [6, 0.5]
        [robots.a]
                ^ robots: `a` is 0.6 m wide and doesn't fit: make the world larger
        [robots.b]
        profile = "quadrotor"
    """)
