"""The words that move a robot, and the velocity of each. Standard library only."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from improv_core.score.movement import Velocity

_HALF = Fraction(1, 2)

PRIMITIVES: Mapping[str, Velocity] = {
    "forward": Velocity(x=1),
    "backward": Velocity(x=-1),
    "left": Velocity(yaw=1),
    "right": Velocity(yaw=-1),
    "halfleft": Velocity(yaw=_HALF),
    "halfright": Velocity(yaw=-_HALF),
    "rest": Velocity(),
    "strafeleft": Velocity(y=1),
    "straferight": Velocity(y=-1),
    "up": Velocity(z=1),
    "down": Velocity(z=-1),
}
"""The velocity of each word. Each moves for one beat."""
