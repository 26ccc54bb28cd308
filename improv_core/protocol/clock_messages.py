"""The messages about a clock from outside that the parent follows (docs/protocol.md). Standard library only."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from improv_core.protocol.fields import Factor
from improv_core.score.fits import Between
from improv_core.score.times import Monotonic

Tempo = Annotated[float, Between(0, 100_000)]
"""Beats per minute, as a clock may report them."""


class AnchorMessage(TypedDict):
    """News from a clock of music: its beat `at` a monotonic time, its tempo in beats per minute (0: it stands), the
    usual seconds until the next message, and the number of its jumps."""

    type: Literal["anchor"]
    at: Monotonic
    beat: float
    tempo: Tempo
    period: float
    jumps: int


class BendMessage(TypedDict):
    """The leading stage's beat `at` a monotonic time, and the pace at which it has followed a clock since then."""

    type: Literal["bend"]
    at: Monotonic
    beat: float
    pace: Factor
