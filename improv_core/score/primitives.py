"""The words that move a robot, the velocity of each, and how long they last. Standard library only."""

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


def pace_text(beats: Fraction) -> str:
    """Return the transformer that makes a movement of one beat last this many."""
    return f"slow {beats}" if beats > 1 else f"fast {1 / beats}"


def rest_text(beats: Fraction) -> str:
    """Return the words that rest for this many beats, as people write them: `repeat 4 rest`, or `fast 2 rest`."""
    if beats == 1:
        return "rest"
    return f"{pace_text(beats) if beats.denominator > 1 else f'repeat {beats}'} rest"
