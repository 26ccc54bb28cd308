"""The clock that a performance follows: its state, and the beat that the performance should have by it. Pure.

Its phase is in beats if it is one of music (MIDI, Ableton Link), and in seconds if it is the time of a simulation.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction

from improv_core.score.peer_clock import Anchor
from improv_core.score.score import Follow, OutsideClock

NAMES: Mapping[Follow, str] = {"ros": "/clock", "midi": "the MIDI clock", "link": "Ableton Link"}
"""The name of each clock, for people."""
LOST = 2.0
"""Seconds of silence after which a clock of music counts as lost, which people are warned of."""
STOPPED = 0.2
"""Seconds without a later time after which the time of a simulation counts as stopped, and at least `MISSED` times as
long as usual passes between two."""
MISSED = 4.0
NOTICED = 0.005
"""The share by which the pace has to change: smaller changes aren't worth a message to each robot."""


@dataclass(frozen=True, slots=True)
class Following:
    """A clock that is followed."""

    follow: Follow
    anchor: Anchor | None = None
    """The latest news of it; None if none has come."""
    ours: float = 0.0
    """The beat that plays when the clock is at `theirs`."""
    theirs: float = 0.0
    slope: Fraction = Fraction(0)
    """Beats from there on for each unit of the clock's phase."""
    silent: bool = False
    """True while no more news comes."""
    looks: float = math.inf
    """The performance time at which to check it again."""
    warned: bool = False
    """True if people know that it is too fast for a robot."""
    enters: float | None = None
    """The performance time at which a pause ends, as the clock is then at the beat of the performance."""

    @property
    def is_music(self) -> bool:
        """True if it counts beats, and not the seconds of a simulation."""
        return self.follow != "ros"

    @property
    def name(self) -> str:
        return NAMES[self.follow]

    @property
    def rate(self) -> float:
        """The units of the clock that pass in a second; 0 if it stands, or if the rate isn't known."""
        return self.anchor.rate if self.anchor else 0.0

    @property
    def stands(self) -> bool:
        """True while robots have to wait for it."""
        if self.is_music:
            return self.enters is not None or (self.anchor is not None and not self.anchor.rate)
        return self.anchor is None or self.silent

    def is_lost(self, now: float) -> bool:
        """Return whether it has been silent for too long at a time on our clock."""
        if not self.anchor or not self.anchor.rate:
            return False
        limit = LOST if self.is_music else max(STOPPED, MISSED * self.anchor.period)
        return now - self.anchor.at > limit

    def beat(self, now: float) -> float:
        """Return the beat that should play at a time on our clock."""
        phase = self.anchor.phase_at(now) if self.anchor else self.theirs
        return self.ours + (phase - self.theirs) * float(self.slope)

    def aligned(self, slope: Fraction, beat: float, now: float) -> Following:
        """Return the clock for a performance that continues from a beat, at a time on our clock. A simulation's time
        counts from there; a musician's beats stay where they are."""
        if not self.anchor:
            return self
        theirs = self.anchor.phase_at(now)
        if not self.is_music:
            return replace(self, ours=beat, theirs=theirs, slope=slope)
        if slope == self.slope:
            return self
        ours = self.beat(now) if self.slope else theirs * float(slope)
        return replace(self, ours=ours, theirs=theirs, slope=slope)

    def late(self, beat: float, bar: int, now: float) -> float:
        """Return the seconds by which a performance at a beat is late. Music counts in bars: the nearest one fits."""
        off = self.beat(now) - beat
        if self.is_music:
            off = math.remainder(off, bar)
        return off / float(self.slope) / self.rate

    def until(self, beat: float, slope: Fraction, bar: int, now: float) -> float:
        """Seconds until it is at this beat of a bar; infinite if that isn't known, or if it isn't of music."""
        if not self.anchor or not self.rate or not self.is_music or self.silent:
            return math.inf
        ours = self.beat(now) if self.slope == slope else self.anchor.phase_at(now) * float(slope)
        return (beat - ours) % bar / float(slope) / self.rate


def lost_line(clock: Following, tempo: float) -> str:
    """Return the line for people when a clock of music is lost. `tempo` is in beats per minute."""
    return f"nothing is heard of {clock.name}: the dance continues at {tempo:.1f} beats per minute"


def found_line(clock: Following) -> str:
    """Return the line for people when a clock that was lost is heard again."""
    return f"{clock.name} is heard again"


def waiting_line(clock: Following) -> str:
    """Return the line for people when robots pause because the clock stands."""
    return f"paused until {clock.name} continues"


def followed(before: Following | None, wanted: OutsideClock | None, real: bool) -> Following | None:
    """The clock that a score wants to follow, on a stage that leads. Only a stage with real robots hears /clock."""
    if not wanted or (wanted.follow == "ros" and not real):
        return None
    return before if before and before.follow == wanted.follow else Following(wanted.follow)
