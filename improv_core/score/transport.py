"""Where playing stands: which beat it is, when the score ends, when another may take over. Standard library only."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from improv_core.score.movement import ENDLESS, Duration, Exact, near

Switch = Literal["now", "beat", "end"]
"""When a score takes over from another: at once, at the next whole beat, or at the end."""


@dataclass(frozen=True, slots=True)
class Transport:
    """A score that plays, or has been left at a beat. Replaced whole whenever it goes on from elsewhere.

    Three kinds of time: the clock's, in seconds; performance time, in seconds since `zero` by the clock; and beats,
    which are places in the score and pass at `tempo`, in beats per minute. At performance time `since`, playing was
    taken up at beat `origin`.
    """

    zero: float
    since: float
    origin: Exact
    tempo: Fraction

    def performed(self, now: float) -> float:
        """The performance time at a time by the clock."""
        return now - self.zero

    def clock(self, performed: float) -> float:
        """The time by the clock at a performance time."""
        return performed + self.zero

    def beat(self, now: float, beats: Duration) -> Exact:
        """The beat at a time by the clock, in a score of so many beats."""
        passed = self.origin + Fraction(max(self.performed(now) - self.since, 0.0)) * self.tempo / 60
        return near(float(min(passed, beats)))

    def end(self, beats: Duration) -> float:
        """The performance time at which a score of so many beats ends."""
        return math.inf if beats == ENDLESS else self.since + float((beats - self.origin) * 60 / self.tempo)

    def switch_time(self, when: Switch, performed: float, beats: Duration) -> float:
        """The performance time, from `performed` on, at which another score takes over from one of so many beats."""
        performed = max(performed, self.since)
        if when == "end" and (end := self.end(beats)) != math.inf:
            return end
        if when == "now":
            return performed
        beat = float(60 / self.tempo)
        first = self.since + float(math.ceil(self.origin) - self.origin) * beat  # the first whole beat since
        return first + max(math.ceil((performed - first) / beat), 0) * beat
