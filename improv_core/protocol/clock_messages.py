"""The messages about a clock from outside that is followed (docs/protocol.md). Standard library only."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from improv_core.protocol.fields import Factor
from improv_core.score.fits import Between

Tempo = Annotated[float, Between(0, 100_000)]
"""Beats per minute, as a clock may tell them."""


class AnchorMessage(TypedDict):
    """Heard of a clock of music: where it was `at` a monotonic time, its tempo in beats per minute (0: it stands), how
    many seconds usually pass until the next one, and how often it has jumped."""

    type: Literal["anchor"]
    at: float
    beat: float
    tempo: Tempo
    period: float
    jumps: int


class BendMessage(TypedDict):
    """The stage that leads was at a beat `at` a monotonic time, and follows a clock at this pace since then."""

    type: Literal["bend"]
    at: float
    beat: float
    pace: Factor


class ClockWarning(TypedDict):
    """One line for people about the clock that is listened to."""

    type: Literal["warning"]
    message: str


class ClockError(TypedDict):
    """One line for people: why the clock can't be heard. The process ends."""

    type: Literal["error"]
    message: str


FromClock = AnchorMessage | ClockWarning | ClockError
"""From the process that listens to MIDI clock or Ableton Link, to the parent."""
