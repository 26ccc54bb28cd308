"""What MIDI says about time: a tick 24 times a beat, start, continue, stop, and song positions. Pure functions."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from improv_core.score.peer_clock import Anchor, Estimate, first_seen, jumped, sighted

TICKS = 24
"""Ticks in a beat, which is a quarter note."""
TICKS_PER_POSITION = 6
"""Ticks in a unit of a song position, which is a sixteenth."""
SILENCE = 0.25
"""Seconds without a tick after which it may be that ticks have been lost: without a stop, the song went on meanwhile.
Or else they were late, and come all at once."""
OFTEN = 0.1
"""Seconds between two anchors, at least."""


@dataclass(frozen=True, slots=True)
class MidiTime:
    """What is known.

    `tick` is the number of the tick that comes next. It `jumps` if the next one is elsewhere in the song, and the song
    `runs` unless a stop says otherwise. An anchor was last `told` at that time, and the last tick came at `ticked`.
    After a pause between ticks, it is `paused` as long as they don't fit.
    """

    tick: int = 0
    jumps: bool = False
    runs: bool = True
    estimate: Estimate | None = None
    told: float = -math.inf
    ticked: float = math.inf
    paused: bool = False


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
