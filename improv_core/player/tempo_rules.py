"""Rules by which a performance follows another clock: it bends. Pure functions: `(run, event, facts) -> (run, acts)`.

A bend changes only the pace of the beats. So the beat never jumps, and robots get new velocities as they do when a
person sets the speed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from improv_core.player import events
from improv_core.player.acts import Act, Dismiss
from improv_core.player.agenda import Due
from improv_core.player.events import Facts
from improv_core.player.run import Run
from improv_core.player.start_rules import OPENS, changed, coming_in, keep_playing, waits
from improv_core.player.stop_rules import RunAndActs, warning_line
from improv_core.protocol.clock_messages import BendMessage
from improv_core.protocol.fields import FASTEST, SLOWEST
from improv_core.score.movement import near
from improv_core.score.outside_clock import NOTICED, Following, found_line, lost_line
from improv_core.score.peer_clock import Anchor, bent
from improv_core.score.ramps import FASTEST_EASE
from improv_core.score.score import Part, Score, in_axes

LOOK = 0.25
"""Seconds until the next check of the clock if no message comes from it: a bend must not last too long."""
SOON = 0.95
"""The share of the tempo at which a robot would be too fast, from which on people get a warning."""


def anchored(run: Run, anchor: Anchor, facts: Facts) -> RunAndActs:
    before = run.clock
    if not before:
        return run, []
    clock = replace(before, anchor=anchor, silent=False)
    run, acts = replace(run, clock=clock), list[Act]()
    if before.silent and before.is_music:
        acts.append(warning_line(found_line(clock)))
    if run.mode == "waiting":
        return _at_bar(run, clock, facts), acts
    if run.mode == "paused" and run.continues and clock.is_music:
        return coming_in(run, facts), acts
    if clock.stands or run.mode == "paused":
        run, more = changed(run, events.Changed(), facts)
        return run, [*acts, *more]
    if run.mode != "playing":
        return run, acts
    performed = run.transport.performed(facts.now)
    if before.anchor and before.anchor.jumps != anchor.jumps and not clock.is_music:
        beat = float(run.beat(facts.now, facts.over))
        run = replace(run, clock=clock.aligned(clock.slope, beat, facts.now))
        acts.append(warning_line(f"the time on {clock.name} has jumped: the dance continues from where it is"))
    run, more = _bend(run, performed, facts)
    return run, [*acts, *more]


def looked(run: Run, due: Due, facts: Facts) -> RunAndActs:
    clock, acts = run.clock, list[Act]()
    assert clock
    now = run.transport.clock(due.at)
    if run.mode == "paused":
        clock = replace(clock, enters=None, looks=math.inf)
        return changed(replace(run, clock=clock), events.Changed(), facts)
    if clock.is_lost(now) and not clock.silent:
        clock = replace(clock, silent=True)
        run = replace(run, clock=clock)
        if not clock.is_music:
            return _stood_still(run, clock, facts)
        acts.append(warning_line(lost_line(clock, float(run.tempo))))
    run, more = _bend(run, due.at, facts)
    return run, [*acts, *more]


def bend(run: Run, message: BendMessage, facts: Facts) -> RunAndActs:
    """Take over the pace of the stage that leads, which it has had since a time on the clock."""
    run = replace(run, pace=Fraction(str(message["pace"])))
    if run.mode != "playing" or waits(run, facts):
        return replace(run, transport=replace(run.transport, tempo=run.tempo)), []
    beat = message["beat"] + max(facts.now - message["at"], 0.0) / run.beat_period
    return keep_playing(run, near(min(beat, float(run.beats(facts.over)))), run.transport.performed(facts.now), facts)


def _stood_still(run: Run, clock: Following, facts: Facts) -> RunAndActs:
    """Pause, because a simulation's time stands still. Robots haven't done what they were sent since then, so it is
    played again, unless senses have decided something meanwhile."""
    then, acts = changed(run, events.Changed(), facts)
    if then.mode != "paused" or not clock.anchor or run.score.open:
        return then, acts
    beat = near(min(max(clock.beat(clock.anchor.at), 0.0), float(then.transport.origin)))
    return then.at_scene_of(then.begun, beat).left_at(beat), [*acts, Dismiss()]


def _bend(run: Run, performed: float, facts: Facts) -> RunAndActs:
    """Play faster or slower, so that the clock and the performance meet."""
    clock, now = run.clock, run.transport.clock(performed)
    assert clock
    if not clock.rate:
        return replace(run, clock=replace(clock, looks=math.inf)), []
    beat = run.beat(now, facts.over)
    if not clock.slope:  # playing began without it
        clock = clock.aligned(run.slope, float(beat), now)
    late = clock.late(float(beat), run.bar, now)
    pace = run.pace_at(bent(clock.anchor, late) if clock.anchor else 0.0)
    rests = clock.silent and abs(pace / run.pace - 1) < NOTICED
    run, acts = _warned(replace(run, clock=replace(clock, looks=math.inf if rests else performed + LOOK)))
    if abs(pace / run.pace - 1) < NOTICED or waits(run, facts):
        return run, acts
    run, more = keep_playing(replace(run, pace=pace), beat, performed, facts)
    return run, [*acts, *more]


def _warned(run: Run) -> RunAndActs:
    """Warn before the clock makes a robot too fast, or if it is too fast or too slow itself."""
    clock = run.clock
    assert clock
    if not clock.is_music:
        return run, []  # velocities are those of the simulation, whatever its speed
    asked = clock.rate * 60 * float(run.speed)
    lowest, highest = (float(run.score.tempo * run.speed) * factor for factor in (SLOWEST, FASTEST))
    robot, most = ceiling(run.score)
    is_fast, is_out = asked > most * SOON, not lowest <= asked <= highest
    if not (is_fast or is_out):
        return replace(run, clock=replace(clock, warned=False)), []
    if clock.warned:
        return run, []
    run = replace(run, clock=replace(clock, warned=True))
    if is_fast and most < highest:
        line = f"{robot} may be too slow from {most:.0f} beats per minute on, so it would leave its path"
    else:
        line = f"the dance plays from {lowest:.0f} to {highest:.0f} beats per minute, so it can't keep up"
    return run, [warning_line(f"{clock.name} runs at {asked:.0f}: {line}")]


def _at_bar(run: Run, clock: Following, facts: Facts) -> Run:
    """Set beat 0 to the next bar of the clock, if it waits for that."""
    gate = run.gate
    if not gate or not gate.at_bar or (gate.ready and abs(gate.late(facts.now, facts.wall)) < OPENS):
        return run
    left = clock.until(0, run.slope, run.bar, facts.now)
    return replace(run, gate=replace(gate, begins=facts.wall + left, opened=facts.now + left))


def ceiling(score: Score) -> tuple[str, float]:
    """Return the first robot that is too slow if the tempo rises, and that tempo in beats per minute.

    This is a bound: a robot may manage more if its voices don't all ask for their most at once.
    """
    each = ((part.robot, _most(part)) for part in score.parts.values())
    return min(each, key=lambda known: known[1], default=("", math.inf))


def _most(part: Part) -> float:
    """Return the tempo up to which a robot stays within its limits."""
    return min((limit * 60 / asked for limit, asked in _asked(part) if asked), default=math.inf)


def _asked(part: Part) -> Iterator[tuple[float, float]]:
    """Yield each limit of a robot, and the speed that a beat per second needs, in m/s and rad/s."""
    profile, peak = part.profile, part.movement.bounds.peak
    faster = float(FASTEST_EASE) if profile.smooth else 1.0
    x, y, z, yaw = in_axes(peak[:4], profile)
    if profile.max_linear is not None:
        yield profile.max_linear, math.hypot(x, y, z) * profile.linear_scale * faster
    if profile.max_angular is not None:
        yield profile.max_angular, yaw * profile.angular_scale * faster
