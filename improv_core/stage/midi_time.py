"""What MIDI says about time: a tick 24 times a beat, start, continue, stop, and song positions. Pure functions."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from improv_core.score.peer_clock import Anchor, Estimate, first_seen, jumped, sighted

TICKS = 24
"""Ticks in a beat, which is a quarter note."""
TICKS_PER_POSITION = 6
"""Ticks in a unit of a song position, which is a sixteenth."""
OFTEN = 0.1
"""Seconds between two anchors, at least."""


@dataclass(frozen=True, slots=True)
class MidiTime:
    """What is known: the number of the tick that comes next, whether it is one after a jump, whether the song runs, as
    it does unless a stop says otherwise, the estimate of the clock, and when an anchor was last passed on."""

    tick: int = 0
    jumps: bool = False
    runs: bool = True
    estimate: Estimate | None = None
    told: float = -math.inf


def heard(time: MidiTime, kind: str, position: int, at: float) -> tuple[MidiTime, Anchor | None]:
    """What is known after a message of this kind, as mido names it, at a time on our clock, and what to pass on.

    The song begins with the tick after a start or a continue.
    """
    if kind == "clock":
        return _ticked(time, at) if time.runs else (time, None)
    if kind == "start":
        return replace(time, tick=0, jumps=True, runs=True), None
    if kind == "continue":
        return replace(time, jumps=True, runs=True), None
    if kind == "songpos":
        return replace(time, tick=position * TICKS_PER_POSITION, jumps=True), None
    if kind == "stop" and time.runs:
        before = time.estimate.anchor if time.estimate else Anchor(at, 0.0, 0.0, 0.0)
        stands = replace(before, at=at, phase=time.tick / TICKS, rate=0.0)
        return replace(time, runs=False, told=at), stands
    return time, None


def _ticked(time: MidiTime, at: float) -> tuple[MidiTime, Anchor | None]:
    phase = time.tick / TICKS
    if not time.estimate:
        known = first_seen(at, phase)
    elif time.jumps:
        known = jumped(time.estimate, at, phase)
    else:
        known = sighted(time.estimate, at, phase)
    then = MidiTime(time.tick + 1, False, True, known, time.told)
    if not known.is_known or known.anchor.at != at or (at - time.told < OFTEN and not time.jumps):
        return then, None
    return replace(then, told=at), known.anchor
