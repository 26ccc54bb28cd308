"""Time from MIDI messages: ticks, 24 per beat; start, continue, stop, and song positions. Pure functions."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from improv_core.score.peer_clock import Anchor, Estimate, first_seen, jumped, sighted

TICKS = 24
"""Ticks in a beat, which is a quarter note."""
TICKS_PER_POSITION = 6
"""Ticks in a unit of a song position, which is a sixteenth."""
SILENCE = 0.25
"""Seconds without a tick after which ticks may have been lost: unless it was stopped, the song kept playing. If they
were only late, they arrive all at once."""
OFTEN = 0.1
"""The least number of seconds between two anchors."""


@dataclass(frozen=True, slots=True)
class MidiTime:
    """The known state of the clock.

    `tick` is the number of the next tick. `jumps` is true if that tick is elsewhere in the song, and the song `runs`
    unless it was stopped. `told` is the time of the latest anchor, and `ticked` that of the latest tick. After a pause
    between ticks, it is `paused` as long as they don't fit.
    """

    tick: int = 0
    jumps: bool = False
    runs: bool = True
    estimate: Estimate | None = None
    told: float = -math.inf
    ticked: float = math.inf
    paused: bool = False


def heard(time: MidiTime, kind: str, position: int, at: float) -> tuple[MidiTime, Anchor | None]:
    """Return the state after a message of this kind, in mido's words, at a time on our clock, and an anchor to pass on.

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
    phase, before = time.tick / TICKS, time.estimate
    paused = time.paused or at - time.ticked > SILENCE
    if not before:
        known = first_seen(at, phase)
    elif time.jumps:
        known = jumped(before, at, phase)
    else:
        known = sighted(before, at, phase, gap=math.inf)
        if known.anchor.jumps > before.anchor.jumps and paused:  # ticks were lost
            time = replace(time, tick=round(before.anchor.phase_at(at) * TICKS))
            known = sighted(replace(before, strayed=None), at, time.tick / TICKS)
    paused &= known.strayed is not None
    then = MidiTime(time.tick + 1, False, True, known, time.told, at, paused)
    if not known.is_known or known.anchor.at != at or (at - time.told < OFTEN and not time.jumps):
        return then, None
    return replace(then, told=at), known.anchor
