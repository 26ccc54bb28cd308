"""How stages on several machines follow a clock of music, which only their parent hears: they are told to bend, all at
the same instants, and to come in together. Nothing here does anything. Standard library only.

For the stages there is no clock: all else is as without one.
"""

from __future__ import annotations

import math
from dataclasses import replace

from improv_core.protocol.clock_messages import AnchorMessage, BendMessage
from improv_core.protocol.commands import Pause
from improv_core.protocol.fields import within_reach
from improv_core.protocol.messages import Load
from improv_core.score.outside_clock import LOST, Following
from improv_core.score.peer_clock import Anchor, bent
from improv_core.session.group.acts import Act, Decided, Say, SendTo, Times, warning
from improv_core.session.group.state import HERE, Troupe, beat_at
from improv_core.session.group.synced_start import EARLY, begin, go, instant

LOOK = 0.25
"""Seconds between two bends, at least."""
NOTICED = 0.005
"""The share by which the pace has to change: smaller changes aren't worth a message to each robot."""


def taken(troupe: Troupe, load: Load) -> tuple[Troupe, Load, list[Act]]:
    """A score is to be played: the clock that it wants to follow is taken out of it, if there are other machines."""
    wanted = load["score"].get("clock")
    if all(host == HERE for host in troupe.members):
        return replace(troupe, clock=None), load, []
    load = {**load, "score": {**load["score"], "clock": None}}  # each would bend by itself, at another instant
    troupe = replace(troupe, looks=-math.inf)
    if wanted and wanted["follow"] == "ros":
        line = "stages on other machines don't follow the time of a simulation: the program's tempo counts"
        return replace(troupe, clock=None), load, [warning(line)]
    if wanted and not (troupe.clock and troupe.clock.follow == wanted["follow"]):
        return replace(troupe, clock=Following(wanted["follow"])), load, []
    return troupe if wanted else replace(troupe, clock=None), load, []


def anchored(troupe: Troupe, heard: AnchorMessage, now: Times) -> Decided:
    """Something is heard of the clock."""
    before = troupe.clock
    assert before
    anchor = Anchor(heard["at"], heard["beat"], heard["tempo"] / 60, heard["period"], heard["jumps"])
    troupe = replace(troupe, clock=replace(before, anchor=anchor, silent=False))
    acts: list[Act] = [warning(f"{before.name} is heard again")] if before.silent else []
    if not anchor.rate:
        troupe, more = _stands(troupe, now)
    elif troupe.mode == "armed" and (troupe.arming is None or troupe.stands) and troupe.enters == math.inf:
        troupe, more = enter(troupe, 0.0, now)
    elif troupe.mode == "paused" and troupe.stands and (position := troupe.position):
        troupe, more = enter(troupe, position["beat"], now)
    else:
        troupe, more = _bend(troupe, now)
    return troupe, [*acts, *more]


def ready(troupe: Troupe, now: Times) -> Decided:
    """All is ready: beat 0 is at the next bar of the clock, once that is heard."""
    troupe = replace(troupe, mode="armed")
    if troupe.is_led:
        return enter(troupe, 0.0, now)
    assert troupe.clock
    return troupe, [
        Say({"type": "armed", "generation": troupe.generation, "armed": True, "begins": None}),
        warning(f"the dance begins at the next bar of {troupe.clock.name}, once it is heard"),
    ]


def enter(troupe: Troupe, beat: float, now: Times) -> Decided:
    """All begin or go on from this beat once the clock is at it, as a musician comes in."""
    clock, soonest = troupe.clock, now.at + troupe.ahead
    assert clock
    left = clock.until(beat, troupe.speed, troupe.bar, soonest)
    troupe = replace(troupe, enters=soonest + left, enters_at=beat, stands=False)
    return waited(troupe, now)


def due(troupe: Troupe) -> float:
    """When `waited` is to be called, in monotonic seconds; infinite if nothing is waited for."""
    enters = troupe.enters - EARLY if troupe.mode in ("armed", "paused") else math.inf
    return min(enters, _lost_at(troupe))


def waited(troupe: Troupe, now: Times) -> Decided:
    """Do what is due: come in, or find out that the clock is lost."""
    clock = troupe.clock
    if clock and troupe.mode in ("armed", "paused") and now.at >= troupe.enters - EARLY:
        at = max(troupe.enters, now.at + troupe.ahead)
        beat = troupe.enters_at
        pace = _pace(troupe, clock.rate)
        told: BendMessage = {"type": "bend", "at": now.at, "beat": beat, "pace": pace}
        clock = clock.aligned(troupe.speed, beat, at)
        bends: list[Act] = [SendTo(host, told) for host in troupe.alive]  # while nothing plays, only the pace counts
        troupe = replace(troupe.without_entry(), clock=clock, bent={**told, "at": at}, looks=at + LOOK)
        troupe, acts = begin(troupe, at) if troupe.mode == "armed" else go(troupe, troupe.alive, beat, at)
        return troupe, [*bends, *acts]
    if clock and now.at >= _lost_at(troupe) and (position := troupe.position):
        line = f"nothing is heard of {clock.name}: the dance goes on at {position['tempo']:.1f} beats per minute"
        return replace(troupe, clock=replace(clock, silent=True)), [warning(line)]
    return troupe, []


def _lost_at(troupe: Troupe) -> float:
    """When the clock is lost if nothing more is heard of it."""
    runs = troupe.mode == "playing" and troupe.position and troupe.is_led
    return troupe.clock.anchor.at + LOST if runs and troupe.clock and troupe.clock.anchor else math.inf


def _stands(troupe: Troupe, now: Times) -> Decided:
    """The clock stands: so do all, until it goes on."""
    if troupe.mode != "playing":
        return (replace(troupe, enters=math.inf, stands=True) if troupe.enters < math.inf else troupe), []
    pause: Pause = {"type": "pause", "at": instant(troupe, now)}
    pauses: list[Act] = [SendTo(host, pause) for host in troupe.alive]
    assert troupe.clock
    line = f"paused until {troupe.clock.name} goes on"
    return replace(troupe, mode="paused", paused_by=frozenset(), stands=True), [*pauses, warning(line)]


def _bend(troupe: Troupe, now: Times) -> Decided:
    """Have all play faster or slower from one instant on, so that they and the clock meet."""
    clock, position, at = troupe.clock, troupe.position, now.at + troupe.ahead
    if troupe.mode != "playing" or position is None or position["state"] != "playing" or now.at < troupe.looks:
        return troupe, []
    assert clock
    latest = troupe.bent if troupe.bent and troupe.bent["at"] > position["monotonic"] else None
    pace = latest["pace"] if latest else position.get("pace", 1.0)
    per_second = float(troupe.tempo * troupe.speed) * pace / 60
    beat = latest["beat"] + (at - latest["at"]) * per_second if latest else beat_at(position, at)
    clock = clock.aligned(troupe.speed, beat, at)
    assert clock.anchor
    late = clock.late(beat, troupe.bar, at)
    asked = _pace(troupe, bent(clock.anchor, late))
    troupe = replace(troupe, clock=clock, looks=now.at + LOOK)
    if abs(asked / pace - 1) < NOTICED:
        return troupe, []
    told: BendMessage = {"type": "bend", "at": at, "beat": max(beat, 0.0), "pace": asked}
    hosts = [host for host in troupe.alive if host not in troupe.joining]
    return replace(troupe, bent=told), [SendTo(host, told) for host in hosts]


def _pace(troupe: Troupe, rate: float) -> float:
    """How many times as fast as the program says all play that play so many beats of the clock a second."""
    return float(within_reach(rate * 60 / float(troupe.tempo)))
