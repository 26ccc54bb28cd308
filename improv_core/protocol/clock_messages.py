"""The messages about a clock from outside that the parent follows (docs/protocol.md). Standard library only."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from improv_core.protocol.fields import Factor
from improv_core.score.json_types import Between, Monotonic

Tempo = Annotated[float, Between(0, 100_000)]
"""Beats per minute, as a clock may report them."""


class AnchorMessage(TypedDict):
    """A clock of music, MIDI or Ableton Link, was at a beat `at` a time, at a tempo in beats per minute (0: it stands).
    The next message usually comes after `period` seconds; `jumps` counts its jumps. Sent to the stage that leads."""

    type: Literal["anchor"]
    at: Monotonic
    beat: float
    tempo: Tempo
    period: float
    jumps: int


class BendMessage(TypedDict):
    """The stage that follows a clock was at a beat `at` a time, and has played `pace` times as fast since: sent to the
    simulator beside it and, ahead of that time, to stages of several hosts, whose own clocks drift apart."""

    type: Literal["bend"]
    at: Monotonic
    beat: float
    pace: Factor
