"""The motion of a robot in a stretch of time, in its own frame. Standard library only."""

from __future__ import annotations

import math
from typing import NamedTuple

from improv_core.score.motion import Pose, Twist

_ARM = 0.5
"""Meters: a turn by an angle counts like a way of this length times the angle."""
_ALIKE = 0.97
"""The cosine of the angle between motions above which they have one direction."""


class Amounts(NamedTuple):
    """All that a robot moves in a stretch, in its own frame: meters forward, left, and up, and radians of turn.

    Over any part of the time, it moves that part of these.
    """

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    yaw: float = 0.0

    @property
    def size(self) -> float:
        return math.hypot(self.x, self.y, self.z, _ARM * self.yaw)

    def pose(self, share: float = 1.0) -> Pose:
        """Return the pose after a share of the stretch, from its start."""
        return Pose().after(Twist(*self), share)

    def times(self, factor: float) -> Amounts:
        return Amounts(self.x * factor, self.y * factor, self.z * factor, self.yaw * factor)

    def is_like(self, other: Amounts) -> bool:
        """Return whether a robot moves along one geometry in both."""
        ways = math.fsum(a * b for a, b in zip(self[:3], other[:3], strict=True))
        return ways + _ARM * _ARM * self.yaw * other.yaw > _ALIKE * self.size * other.size


def amounts_between(one: Pose, other: Pose, turn: float) -> Amounts:
    """Return the constant motion from one pose to the other that turns by `turn` radians in all.

    It is the logarithm of the displacement (Lynch & Park, Modern Robotics, 3.3.3).
    """
    moved = one.inverse().then(other)
    half = turn / 2
    shrink = 1.0 if abs(half) < 1e-9 else half / math.sin(half) if abs(math.sin(half)) > 1e-9 else math.inf
    if math.isinf(shrink):  # whole circles: the way is not in the displacement
        return Amounts(z=moved.z, yaw=turn)
    way = complex(moved.x, moved.y) * complex(math.cos(half), -math.sin(half)) * shrink
    return Amounts(way.real, way.imag, moved.z, turn)
