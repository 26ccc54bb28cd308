"""The floor, walls, and boxes of `improv.toml`, and robots that start inside them."""

from __future__ import annotations

import math

from improv_core.score.world import Box, Circle, Wall, World
from tests.robots.drawing import check


def test_a_world() -> None:
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


def test_wrong_parts_of_a_world_are_left_out() -> None:
    found = check("""
        [world]
        size = [6, 0]
                   ^ robots: write this in meters, from 0.001 to 1000
        walls = [[0, 0, 1], [0, 0, 1, 1]]
                 ^^^^^^^^^ robots: write this as a wall: 4 numbers in meters, from x, y to x, y, such as `[0, 0, 2, 0]`
        circles = [{ x = 1 }, 3, { radius = 0.3, tint = 1 }]
                   ^^^^^^^^^ robots: add `radius`, in meters
                              ^ robots: write this as a round obstacle, such as `{ x = 1, y = 0, radius = 0.3 }`
                                                 ^^^^ robots: `tint` is not valid here: write one of `x`, `y`, `radius`
        lake = 1
        ^^^^ robots: `lake` is not valid here: write one of `size`, `walls`, `circles`, `boxes`, `margin`, `keep_apart`
    """)
    assert found.world == World(walls=(Wall(0, 0, 1, 1),), circles=(Circle(0, 0, 0.3),))


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
