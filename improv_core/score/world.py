"""The surroundings of simulated robots: walls and obstacles, in meters and radians. Standard library only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple


class Wall(NamedTuple):
    """A line from one point to another."""

    x1: float
    y1: float
    x2: float
    y2: float


class Circle(NamedTuple):
    """A round obstacle."""

    x: float
    y: float
    radius: float


class Box(NamedTuple):
    """A rectangular obstacle with its center at x, y. `heading` is the direction of its width."""

    x: float
    y: float
    width: float
    height: float
    heading: float = 0.0


@dataclass(frozen=True, slots=True)
class World:
    """All obstacles, and the size of the floor along x and y if it has walls around it.

    The origin is the center of the floor. Obstacles are infinitely high. `margin` is the distance that robots should
    keep from each other and from all obstacles. Real robots pause if their edges come nearer to each other than
    `keep_apart`; None if nothing guards that.
    """

    size: tuple[float, float] | None = None
    walls: tuple[Wall, ...] = ()
    circles: tuple[Circle, ...] = ()
    boxes: tuple[Box, ...] = ()
    margin: float = 0.0
    keep_apart: float | None = None

    @property
    def has_obstacles(self) -> bool:
        return bool(self.size or self.walls or self.circles or self.boxes)

    def all_walls(self) -> Iterator[Wall]:
        """Yield the listed walls and those around the floor."""
        yield from self.walls
        if self.size:
            x, y = self.size[0] / 2, self.size[1] / 2
            corners = [(-x, -y), (x, -y), (x, y), (-x, y), (-x, -y)]
            for one, other in pairwise(corners):
                yield Wall(*one, *other)

    def holds(self, x: float, y: float) -> bool:
        """Return whether a point is on the floor."""
        return self.size is None or (abs(x) <= self.size[0] / 2 and abs(y) <= self.size[1] / 2)


EMPTY = World()
