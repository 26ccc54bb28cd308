"""The messages between a stage and the process that publishes its playback (docs/protocol.md). Standard library
only."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict

from improv_core.protocol.messages import ErrorLine, Sensed, TransportMessage, WarningLine
from improv_core.protocol.robot_messages import FaultMessage, Measured


class Plays(TypedDict):
    """A score has arrived at the stage, as `score_json.to_json` writes it."""

    type: Literal["plays"]
    generation: int
    score: Mapping[str, Any]


class Health(TypedDict):
    """The delivery of commands to robots: `late` is the longest delay in seconds, `missing` has the reasons why robots
    can't receive them, and `clipped` are the robots whose commands exceeded their limits."""

    type: Literal["health"]
    late: float
    missing: Mapping[str, str]
    clipped: Sequence[str]


ToPublisher = Plays | TransportMessage | Sensed | Measured | WarningLine | ErrorLine | FaultMessage | Health
"""From the stage to the process that publishes its playback, over a pipe."""
FromPublisher = ErrorLine
"""From that process to the stage: the reason why it ends."""
