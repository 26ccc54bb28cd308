"""The messages between the parent and the processes of music: OSC, MIDI clock, and Ableton Link (docs/protocol.md).
Standard library only."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypedDict

from improv_core.protocol.clock_messages import AnchorMessage
from improv_core.protocol.json_lines import Alive
from improv_core.protocol.messages import Armed, ErrorLine, Request, Sensed, TransportMessage, WarningLine
from improv_core.protocol.publisher_messages import Plays


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
