"""What a kind of robot is like: how far a step goes, how wide a quarter turn is, how often it wants a command."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Profile:
    """A kind of robot. `step` and `radius` in metres, `quarter_turn` in radians, `command_rate` in Hz."""

    name: str
    step: float
    quarter_turn: float = math.pi / 2
    command_rate: float = 20.0
    radius: float = 0.3


# turtlesim stops a turtle 1 s after its last command, diff_drive_controller a robot after 0.5 s; 20 Hz leaves room.
TURTLESIM = Profile("turtlesim", step=2.0)
