"""The obstacles of robots: the distance of a place from each thing in the world. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import NamedTuple

from improv_core.score.approach import Convex
from improv_core.score.trajectories import Volume
from improv_core.score.world import Box, Circle, Wall, World

EDGE = "edge"
"""The name of all four edges of the floor."""
GROUND = "ground"
"""The name of the ground, at a height of 0. No robot can fly below it."""


class Obstacle(NamedTuple):
    """One thing in the world, or one edge of the floor, and a box around it."""

    name: str
    distance: Convex
    box: Volume


def obstacles(world: World) -> Iterator[Obstacle]:
    """Yield all things in the world, each with its kind and number, such as `wall 1`. The edges have one name."""
    for number, wall in enumerate(world.walls, 1):
        xs, ys = sorted((wall.x1, wall.x2)), sorted((wall.y1, wall.y2))
        yield Obstacle(f"wall {number}", partial(_to_wall, wall), _high(xs[0], ys[0], xs[1], ys[1]))
    for number, circle in enumerate(world.circles, 1):
        yield Obstacle(f"circle {number}", partial(_to_circle, circle), _square(circle.x, circle.y, circle.radius))
    for number, box in enumerate(world.boxes, 1):
        out = math.hypot(box.width, box.height) / 2
        yield Obstacle(f"box {number}", partial(_to_box, box), _square(box.x, box.y, out))
    if world.size:
        x, y = world.size[0] / 2, world.size[1] / 2
        yield Obstacle(EDGE, partial(_to_edge, 1.0, 0.0, x), _high(x, -math.inf, math.inf, math.inf))
        yield Obstacle(EDGE, partial(_to_edge, -1.0, 0.0, x), _high(-math.inf, -math.inf, -x, math.inf))
        yield Obstacle(EDGE, partial(_to_edge, 0.0, 1.0, y), _high(-math.inf, y, math.inf, math.inf))
        yield Obstacle(EDGE, partial(_to_edge, 0.0, -1.0, y), _high(-math.inf, -math.inf, math.inf, -y))


def _high(x0: float, y0: float, x1: float, y1: float) -> Volume:
    """Return a box without a top or a bottom, as obstacles have none."""
    return Volume(x0, y0, -math.inf, x1, y1, math.inf)


def _square(x: float, y: float, out: float) -> Volume:
    return _high(x - out, y - out, x + out, y + out)


def _to_edge(out_x: float, out_y: float, out: float, x: float, y: float) -> tuple[float, float, float]:
    """Return the distance from an edge, negative outside, and the direction toward it."""
    return out - (x * out_x + y * out_y), out_x, out_y


def _to_circle(circle: Circle, x: float, y: float) -> tuple[float, float, float]:
    toward_x, toward_y = circle.x - x, circle.y - y
    far = math.hypot(toward_x, toward_y)
    return (far - circle.radius, toward_x / far, toward_y / far) if far else (-circle.radius, 0.0, 0.0)


def _to_wall(wall: Wall, x: float, y: float) -> tuple[float, float, float]:
    length_x, length_y = wall.x2 - wall.x1, wall.y2 - wall.y1
    square = length_x * length_x + length_y * length_y
    share = ((x - wall.x1) * length_x + (y - wall.y1) * length_y) / square if square else 0.0
    share = min(max(share, 0.0), 1.0)
    return _toward(wall.x1 + share * length_x - x, wall.y1 + share * length_y - y)


def _to_box(box: Box, x: float, y: float) -> tuple[float, float, float]:
    """Return the distance from a box, 0 inside, and the direction toward it."""
    cos, sin = math.cos(box.heading), math.sin(box.heading)
    ahead, left = (x - box.x) * cos + (y - box.y) * sin, (y - box.y) * cos - (x - box.x) * sin
    ahead = min(max(ahead, -box.width / 2), box.width / 2) - ahead
    left = min(max(left, -box.height / 2), box.height / 2) - left
    return _toward(ahead * cos - left * sin, ahead * sin + left * cos)


def _toward(x: float, y: float) -> tuple[float, float, float]:
    far = math.hypot(x, y)
    return (far, x / far, y / far) if far else (0.0, 0.0, 0.0)
