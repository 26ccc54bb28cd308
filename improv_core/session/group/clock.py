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
from improv_core.protocol.messages import Load
from improv_core.score.outside_clock import LOST, NOTICED, Following, found_line, lost_line, waiting_line
from improv_core.score.peer_clock import Anchor, bent
from improv_core.session.group.acts import Act, Decided, Say, SendTo, Times, warning
from improv_core.session.group.state import HERE, GroupState, beat_at
from improv_core.session.group.synced_start import EARLY, begin, instant, resume_at

LOOK = 0.25
"""The fewest seconds between two bends."""


def taken(group: GroupState, load: Load) -> tuple[GroupState, Load, list[Act]]:
    """Take the clock that a score should follow out of that score, if there are other machines."""
    wanted = load["score"].get("clock")
    if all(host == HERE for host in group.members):
        return replace(group, clock=None), load, []
    load = {**load, "score": {**load["score"], "clock": None}}  # otherwise each stage would follow the clock by itself
    group = replace(group, looks=-math.inf)
    if wanted and wanted["follow"] == "ros":
        line = "stages on other machines don't follow the time of a simulation: the program's tempo counts"
        return replace(group, clock=None), load, [warning(line)]
    if wanted and not (group.clock and group.clock.follow == wanted["follow"]):
        return replace(group, clock=Following(wanted["follow"])), load, []
    return group if wanted else replace(group, clock=None), load, []


def anchored(group: GroupState, heard: AnchorMessage, now: Times) -> Decided:
    """Take news of the clock."""
    before = group.clock
    assert before
    anchor = Anchor(heard["at"], heard["beat"], heard["tempo"] / 60, heard["period"], heard["jumps"])
    group = replace(group, clock=replace(before, anchor=anchor, silent=False))
    acts: list[Act] = [warning(found_line(before))] if before.silent else []
    if not anchor.rate:
        group, more = _stands(group, now)
    elif group.mode == "armed" and (group.arming is None or group.stands) and group.enters == math.inf:
        group, more = enter(group, 0.0, now)
    elif group.mode == "paused" and group.stands and (position := group.position):
        group, more = enter(group, position["beat"], now)
    else:
        group, more = _bend(group, now)
    return group, [*acts, *more]


def ready(group: GroupState, now: Times) -> Decided:
    """Begin, now that all are ready: beat 0 is at the next bar of the clock, once its beat is known."""
    group = replace(group, mode="armed")
    if group.is_led:
        return enter(group, 0.0, now)
    assert group.clock
    return group, [
        Say({"type": "armed", "generation": group.generation, "armed": True, "begins": None}),
        warning(f"the dance begins at the next bar of {group.clock.name}, once it is heard"),
    ]


def enter(group: GroupState, beat: float, now: Times) -> Decided:
    """Have all begin or continue from this beat once the clock reaches it, as a musician comes in."""
    clock, soonest = group.clock, now.at + group.ahead
    assert clock
    left = clock.until(beat, group.speed, group.bar, soonest)
    group = replace(group, enters=soonest + left, enters_at=beat, stands=False)
    return waited(group, now)


def due(group: GroupState) -> float:
    """Return the time of the next call of `waited`, in monotonic seconds; infinite if there is none."""
    enters = group.enters - EARLY if group.mode in ("armed", "paused") else math.inf
    return min(enters, _lost_at(group))


def waited(group: GroupState, now: Times) -> Decided:
    """Do what is due: come in, or notice that the clock is lost."""
    clock = group.clock
    if clock and group.mode in ("armed", "paused") and now.at >= group.enters - EARLY:
        at = max(group.enters, now.at + group.ahead)
        beat = group.enters_at
        pace = _pace(group, clock.rate)
        told: BendMessage = {"type": "bend", "at": now.at, "beat": beat, "pace": pace}
        clock = clock.aligned(group.speed, beat, at)
        bends: list[Act] = [SendTo(host, told) for host in group.alive]  # while nothing plays, only the pace counts
        group = replace(group.without_entry(), clock=clock, bent={**told, "at": at}, looks=at + LOOK)
        group, acts = begin(group, at) if group.mode == "armed" else resume_at(group, group.alive, beat, at)
        return group, [*bends, *acts]
    if clock and now.at >= _lost_at(group) and (position := group.position):
        return replace(group, clock=replace(clock, silent=True)), [warning(lost_line(clock, position["tempo"]))]
    return group, []


def _lost_at(group: GroupState) -> float:
    """Return the time at which the clock is lost if no more news comes."""
    runs = group.mode == "playing" and group.position and group.is_led
    return group.clock.anchor.at + LOST if runs and group.clock and group.clock.anchor else math.inf


def _stands(group: GroupState, now: Times) -> Decided:
    """Have all stand while the clock stands."""
    if group.mode != "playing":
        return (replace(group, enters=math.inf, stands=True) if group.enters < math.inf else group), []
    pause: Pause = {"type": "pause", "at": instant(group, now)}
    pauses: list[Act] = [SendTo(host, pause) for host in group.alive]
    assert group.clock
    line = waiting_line(group.clock)
    return replace(group, mode="paused", paused_by=frozenset(), stands=True), [*pauses, warning(line)]


def _bend(group: GroupState, now: Times) -> Decided:
    """Have all play faster or slower from one instant on, so that they and the clock meet."""
    clock, position, at = group.clock, group.position, now.at + group.ahead
    if group.mode != "playing" or position is None or position["state"] != "playing" or now.at < group.looks:
        return group, []
    assert clock
    latest = group.bent if group.bent and group.bent["at"] > position["monotonic"] else None
    pace = latest["pace"] if latest else position.get("pace", 1.0)
    per_second = float(group.tempo * group.speed) * pace / 60
    beat = latest["beat"] + (at - latest["at"]) * per_second if latest else beat_at(position, at)
    clock = clock.aligned(group.speed, beat, at)
    assert clock.anchor
    late = clock.late(beat, group.bar, at)
    asked = _pace(group, bent(clock.anchor, late))
    group = replace(group, clock=clock, looks=now.at + LOOK)
    if abs(asked / pace - 1) < NOTICED:
        return group, []
    told: BendMessage = {"type": "bend", "at": at, "beat": max(beat, 0.0), "pace": asked}
    hosts = [host for host in group.alive if host not in group.joining]
    return replace(group, bent=told), [SendTo(host, told) for host in hosts]


def _pace(group: GroupState, rate: float) -> float:
    """Return the factor for the program's tempo at which all play this many beats of the clock a second."""
    return float(within_reach(rate * 60 / float(group.tempo)))
