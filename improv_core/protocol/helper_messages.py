"""The messages of helpers (`ipc/helper.py`): the processes that publish what plays, speak OSC, or listen to a clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict

from improv_core.protocol.clock_messages import AnchorMessage
from improv_core.protocol.json_lines import Alive
from improv_core.protocol.messages import Armed, ErrorLine, Request, Sensed, TransportMessage, WarningLine
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


class PeerJson(TypedDict):
    """A host and a UDP port on it."""

    host: str
    port: int


class OscExchange(TypedDict):
    """Exchange messages with these peers from now on: `plays` and other news go to them, in bundles with `time_tags` or
    not, and requests arrive at the given port (null: nowhere)."""

    type: Literal["exchange"]
    send: Sequence[PeerJson]
    listen: PeerJson | None
    time_tags: bool


ToOsc = OscExchange | Plays | TransportMessage | Sensed | Armed
"""From the parent to the process that speaks OSC, over a pipe."""
FromOsc = Alive | Request | WarningLine
"""From that process to the parent: its start, requests, and lines for people."""

FromClock = AnchorMessage | WarningLine | ErrorLine
"""From the process that listens to MIDI clock or Ableton Link, to the parent. An error is why the clock can't be
followed: the process ends."""
