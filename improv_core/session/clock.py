"""Lets stages on several machines follow a clock of music, which only their parent hears: it has them bend, all at the
same instants, and come in together. Decisions without side effects. Standard library only.

For the stages there is no clock: everything else is as without one.
"""

from __future__ import annotations

import math
from dataclasses import replace

from improv_core.protocol.clock_messages import AnchorMessage, BendMessage
from improv_core.protocol.commands import Pause
from improv_core.protocol.fields import within_reach
from improv_core.score.outside_clock import LOST, NOTICED, Following, found_line, lost_line, waiting_line
from improv_core.score.peer_clock import Anchor, bent
from improv_core.session import together
from improv_core.session.acts import Act, Announce, Now, StateAndActs, send, warning
from improv_core.session.state import SessionState

LOOK = 0.25
"""The fewest seconds between two bends."""


def follow(state: SessionState) -> StateAndActs:
    """Follow the clock that the score of real robots names, instead of each stage: they are sent no clock."""
    wanted = state.on_robots.score.clock
    state = replace(state, looks=-math.inf)
    if wanted and wanted.follow == "ros":
        line = "stages on other machines don't follow the time of a simulation: the program's tempo counts"
        return replace(state, following=None), [warning(line)]
    if wanted and not (state.following and state.following.follow == wanted.follow):
        return replace(state, following=Following(wanted.follow)), []
    return state if wanted else replace(state, following=None), []


def anchored(state: SessionState, heard: AnchorMessage, now: Now) -> StateAndActs:
    before = state.following
    assert before
    anchor = Anchor(heard["at"], heard["beat"], heard["tempo"] / 60, heard["period"], heard["jumps"])
    state = replace(state, following=replace(before, anchor=anchor, silent=False))
    acts: list[Act] = [warning(found_line(before))] if before.silent else []
    if not anchor.rate:
        state, more = _stands(state, now)
    elif state.mode == "armed" and (state.on_robots.arming is None or state.stands) and state.enters == math.inf:
        state, more = enter(state, 0.0, now)
    elif state.mode == "paused" and state.stands and (lead := together.position(state)):
        state, more = enter(state, lead["beat"], now)
    else:
        state, more = _bend(state, now)
    return state, [*acts, *more]


def ready(state: SessionState, now: Now) -> StateAndActs:
    """Begin, now that all are ready: beat 0 is at the next bar of the clock, once its beat is known."""
    state = replace(state, mode="armed")
    if together.is_led(state):
        return enter(state, 0.0, now)
    assert state.following
    return state, [
        Announce({"type": "armed", "generation": state.generation, "armed": True, "begins": None}),
        warning(f"the dance begins at the next bar of {state.following.name}, once it is heard"),
    ]


def enter(state: SessionState, beat: float, now: Now) -> StateAndActs:
    """Have all begin or continue from this beat once the clock reaches it, as a musician comes in."""
    clock, soonest = state.following, now.at + together.ahead(state)
    assert clock
    left = clock.until(beat, together.speed(state), together.bar(state), soonest)
    state = replace(state, enters=soonest + left, enters_at=beat, stands=False)
    return waited(state, now)


def due(state: SessionState) -> float:
    """Return the time of the next call of `waited`, in monotonic seconds; infinite if there is none."""
    enters = state.enters - together.EARLY if state.mode in ("armed", "paused") else math.inf
    return min(enters, _lost_at(state))


def waited(state: SessionState, now: Now) -> StateAndActs:
    """Do what is due: have robots come in, or handle the loss of the clock."""
    clock = state.following
    if clock and state.mode in ("armed", "paused") and now.at >= state.enters - together.EARLY:
        at = max(state.enters, now.at + together.ahead(state))
        beat = state.enters_at
        pace = _pace(state, clock.rate)
        told: BendMessage = {"type": "bend", "at": now.at, "beat": beat, "pace": pace}
        clock = clock.aligned(together.speed(state), beat, at)
        bends: list[Act] = [send(host, told) for host in state.alive]  # while nothing plays, only the pace counts
        state = replace(together.without_entry(state), following=clock, bent={**told, "at": at}, looks=at + LOOK)
        state, acts = (
            together.begin(state, at) if state.mode == "armed" else together.resume_at(state, state.alive, beat, at)
        )
        return state, [*bends, *acts]
    if clock and now.at >= _lost_at(state) and (lead := together.position(state)):
        return replace(state, following=replace(clock, silent=True)), [warning(lost_line(clock, lead["tempo"]))]
    return state, []


def _lost_at(state: SessionState) -> float:
    """Return the time at which the clock is lost if no more news comes."""
    runs = state.mode == "playing" and together.position(state) and together.is_led(state)
    return state.following.anchor.at + LOST if runs and state.following and state.following.anchor else math.inf


def _stands(state: SessionState, now: Now) -> StateAndActs:
    if state.mode != "playing":
        return (replace(state, enters=math.inf, stands=True) if state.enters < math.inf else state), []
    pause: Pause = {"type": "pause", "at": together.instant(state, now)}
    pauses: list[Act] = [send(host, pause) for host in state.alive]
    assert state.following
    line = waiting_line(state.following)
    return replace(state, mode="paused", paused_by=frozenset(), stands=True), [*pauses, warning(line)]


def _bend(state: SessionState, now: Now) -> StateAndActs:
    """Have all play faster or slower from one instant on, so that they and the clock meet."""
    clock, lead, at = state.following, together.position(state), now.at + together.ahead(state)
    if state.mode != "playing" or lead is None or lead["state"] != "playing" or now.at < state.looks:
        return state, []
    assert clock
    latest = state.bent if state.bent and state.bent["at"] > lead["monotonic"] else None
    pace = latest["pace"] if latest else lead.get("pace", 1.0)
    per_second = float(state.on_robots.score.tempo * together.speed(state)) * pace / 60
    beat = latest["beat"] + (at - latest["at"]) * per_second if latest else together.beat_at(lead, at)
    clock = clock.aligned(together.speed(state), beat, at)
    assert clock.anchor
    late = clock.late(beat, together.bar(state), at)
    asked = _pace(state, bent(clock.anchor, late))
    state = replace(state, following=clock, looks=now.at + LOOK)
    if abs(asked / pace - 1) < NOTICED:
        return state, []
    told: BendMessage = {"type": "bend", "at": at, "beat": max(beat, 0.0), "pace": asked}
    hosts = [host for host in state.alive if host not in state.joining]
    return replace(state, bent=told), [send(host, told) for host in hosts]


def _pace(state: SessionState, rate: float) -> float:
    """Return the factor for the program's tempo at which all play this many beats of the clock a second."""
    return float(within_reach(rate * 60 / float(state.on_robots.score.tempo)))
