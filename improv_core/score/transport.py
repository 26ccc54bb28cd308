"""The playback position: the current beat, the end of the score, and the time of a takeover. Standard library only."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from improv_core.score.movement import ENDLESS, Duration, Exact, near

Switch = Literal["now", "beat", "bar", "end"]
"""The time at which a score takes over: at once, at the next whole beat, at the next bar, or at the end."""
BEATS_PER_BAR = 4
"""The usual number of beats in a bar."""


@dataclass(frozen=True, slots=True)
class Transport:
    """The position in a score that plays or was left at a beat. Replaced as a whole when playback moves elsewhere.

    There are three kinds of time: the clock's, in seconds; performance time, in seconds since `zero` on the clock; and
    beats, which are positions in the score and pass at `tempo`, in beats per minute. At performance time `since`,
    playback started from beat `origin`.
    """

    zero: float
    since: float
    origin: Exact
    tempo: Fraction

    def performed(self, now: float) -> float:
        """Return the performance time at a time on the clock."""
        return now - self.zero

    def clock(self, performed: float) -> float:
        return performed + self.zero

    def beat(self, now: float, beats: Duration) -> Exact:
        """Return the beat at a time on the clock, in a score that lasts `beats`."""
        passed = self.origin + Fraction(max(self.performed(now) - self.since, 0.0)) * self.tempo / 60
        return near(float(min(passed, beats)))

    def end(self, beats: Duration) -> float:
        """Return the performance time at which a score that lasts `beats` ends."""
        return math.inf if beats == ENDLESS else self.since + float((beats - self.origin) * 60 / self.tempo)

    def switch_time(self, when: Switch, performed: float, beats: Duration, beats_per_bar: int = BEATS_PER_BAR) -> float:
        """The performance time, `performed` or later, at which another score takes over from one that lasts `beats`."""
        performed = max(performed, self.since)
        if when == "end" and (end := self.end(beats)) != math.inf:
            return end
        if when == "now":
            return performed
        step = beats_per_bar if when == "bar" else 1
        seconds = float(step * 60 / self.tempo)
        first = self.since + float(math.ceil(Fraction(self.origin) / step) * step - self.origin) * float(
            60 / self.tempo
        )
        return first + max(math.ceil((performed - first) / seconds), 0) * seconds
