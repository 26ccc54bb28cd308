"""Facts about the stages of real robots on several machines, which play as one, and the instants at which all begin,
continue, and obey requests. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from typing import Any

from improv_core.protocol.commands import AUTOMATIONS, Automation, Resume
from improv_core.protocol.limits import MAX_AHEAD
from improv_core.protocol.messages import CountJson, TransportMessage
from improv_core.score.takeover import Takeover
from improv_core.session.acts import Act, Now, StateAndActs, send
from improv_core.session.state import HERE, SessionState, StageKey

SPARE = 0.03
"""Seconds by which a message that is sent ahead over a network should arrive early."""
HANDED = 0.01
"""Seconds in which a stage on this machine gets a message, unless the machine is overloaded."""
EDGE = 0.01
"""Seconds around a beat in which no instant is chosen, since two stages might take it for another beat."""
DRIFT_PERIOD = 10.0
"""Seconds after which all get the lead's position again: two clocks may drift by 0.1 ms in each."""
RESUME: Resume = {"type": "resume"}
EARLY = 1.0
"""Seconds before the time at which a dance begins by itself, from which on all are sent that time."""


def others(state: SessionState, host: str) -> list[str]:
    """Return the hosts whose stages are alive, except this one."""
    return [each for each in state.alive if each != host]


def playing(state: SessionState) -> list[str]:
    """Return the hosts whose stages are alive and play along, if anything plays."""
    return [host for host in state.alive if host not in {*state.joining, *state.entering}]


def lead(state: SessionState) -> str | None:
    """Return the host whose stage's position counts for all: the first one that plays and moves robots."""
    with_robots = {host_of(state, robot) for robot in state.on_robots.score.parts}
    return min(playing(state), key=lambda host: (host not in with_robots, host), default=None)


def position(state: SessionState) -> TransportMessage | None:
    host = lead(state)
    return state.robots[host].transport if host is not None else None


def host_of(state: SessionState, robot: str) -> str:
    part = state.on_robots.score.parts.get(robot)
    return part.host.name if part and part.host else HERE


def robots_of(state: SessionState, host: str) -> list[str]:
    return [robot for robot in state.on_robots.score.parts if host_of(state, robot) == host]


def ahead(state: SessionState) -> float:
    """Return the seconds by which all must get a command early in order to obey it at the same instant."""
    return min(max((stage.lag for stage in state.robots.values() if stage.alive), default=0.0), MAX_AHEAD)


def bar(state: SessionState) -> int:
    return state.on_robots.score.bar or state.on_robots.beats_per_bar


def speed(state: SessionState) -> Fraction:
    asked = state.kept.get("speed")
    return Fraction(str(asked["factor"] if asked and asked["type"] == "speed" else 1.0))


def count(state: SessionState) -> CountJson | None:
    """Return the count of each stage before beat 0, from when it is sent the time to begin."""
    if not state.on_robots.score.count_in or state.following:
        return None
    return {"beats": bar(state), "period": 60 / float(state.on_robots.score.tempo * speed(state))}


def begins(state: SessionState) -> float:
    """Return the time at which beat 0 comes by itself while it waits for a person, in Unix time; infinite if never."""
    return (state.on_robots.arming or {}).get("begins", math.inf)


def opens(state: SessionState) -> float:
    """Return the Unix time at which all have to be sent their start if they begin by themselves, after a count."""
    counted = count(state)
    return begins(state) - (counted["beats"] * counted["period"] if counted else 0.0)


def is_led(state: SessionState) -> bool:
    """Return whether all follow a clock that runs."""
    return state.following is not None and state.following.rate > 0 and not state.following.silent


def may_start(state: SessionState, by: Automation | None) -> bool:
    """Return whether an automation, or a person (None), may have robots begin or continue, by all stages' reports."""
    said = [stage.transport for stage in state.robots.values() if stage.alive]
    return by is None or all(by in each.get("startable_by", AUTOMATIONS) for each in said if each)


def repeats(state: SessionState, host: str) -> bool:
    """Return whether a stage has paused because of robots that another one had found too near to each other before."""
    first = state.robots.get(state.paused_first or HERE)
    one, other = first and first.transport, state.robots[host].transport
    if state.mode != "paused" or state.paused_first in (None, host) or not one or not other:
        return False
    near = {*other.get("too_near", ())}
    return bool(near) and near <= {*one.get("too_near", ())}


def is_apart(state: SessionState, host: str) -> bool:
    """Return whether a stage has begun a scene at another beat than the lead."""
    one, other = position(state), state.robots[host].transport
    if not one or not other or one["generation"] != other["generation"] or other["state"] != "playing":
        return False
    known, here = one.get("scene"), other.get("scene")
    if not known or not here:
        return False
    return known["index"] == here["index"] and known["begins"] != here["begins"]


def without(state: SessionState, host: str) -> SessionState:
    """Return the state without a stage among those that join: the others don't wait for it."""
    left = {host}
    entering = {each: generation for each, generation in state.entering.items() if each != host}
    return replace(state, joining=state.joining - left, entering=entering, paused_by=state.paused_by - left)


def without_entry(state: SessionState) -> SessionState:
    """Return the state with nothing that begins or continues by the clock."""
    return replace(state, enters=math.inf, stands=False)


def stopped(state: SessionState) -> SessionState:
    """Return the state with nothing that plays or joins."""
    none: frozenset[str] = frozenset()
    return replace(without_entry(state), mode="stopped", joining=none, entering={}, paused_by=none)


def with_all(state: SessionState, hosts: Iterable[str], **changes: Any) -> SessionState:
    """Return the state with the same changes to the stages of these hosts."""
    for host in hosts:
        state = state.with_stage(StageKey(host, "ros"), **changes)
    return state


def beat_at(transport: TransportMessage, at: float) -> float:
    """Return the beat at a time, which may be before the latest report: that was sent ahead."""
    if transport["state"] != "playing":
        return transport["beat"]
    return max(transport["beat"] + (at - transport["monotonic"]) * transport["tempo"] / 60, 0.0)


def entry_at(transport: TransportMessage, beat: float, monotonic: float) -> Takeover:
    """Return the takeover of a stage that joins one that is at this beat at that time."""
    entry: Takeover = {"beat": beat, "monotonic": monotonic}
    if "begins" in transport:
        entry["begins"] = transport["begins"]
    if "scene" in transport:
        entry["scene"] = transport["scene"]
    if "pace" in transport:
        entry["pace"] = transport["pace"]
    return entry


def resume_at(
    state: SessionState, hosts: Iterable[str], beat: float, at: float, resume: Resume = RESUME
) -> StateAndActs:
    """Have paused stages continue from one beat, all at the same time."""
    state = playing_from(state, at)
    acts, timed = list[Act](), resume.copy()
    timed["at"] = at
    for host in hosts:
        if host in state.joining:
            continue
        transport = state.robots[host].transport
        if transport and transport["beat"] != beat:
            acts.append(send(host, {"type": "seek", "beat": beat, "at": at}))
        acts.append(send(host, timed))
    return state, acts


def playing_from(state: SessionState, at: float) -> SessionState:
    """Return the state in which all that are paused play from this time on."""
    # The pause may have made void what stages that are about to enter were sent: they join again.
    joining = state.joining | state.entering.keys()
    state = replace(without_entry(state), mode="playing", joining=joining, entering={})
    return replace(state, paused_by=frozenset(), since=at, drifts=at + DRIFT_PERIOD)


def begin(state: SessionState, at: float) -> StateAndActs:
    state = replace(without_entry(state), mode="playing", since=at, drifts=at + DRIFT_PERIOD)
    return state, [send(host, {"type": "resume", "at": at}) for host in state.alive]


def instant(state: SessionState, now: Now) -> float:
    """Return a time by which all have received a message that is sent now, and that isn't too close to a beat."""
    at, lead = now.at + ahead(state), position(state)
    if lead is None or lead["state"] != "playing":
        return at
    beat, edge = beat_at(lead, at), EDGE * lead["tempo"] / 60
    return at + 2 * EDGE if abs(beat - round(beat)) < edge else at


def settling(state: SessionState, now: Now) -> SessionState:
    """Return the state after a request to all: no stage gets the others' position until the result of that is known."""
    known = now.at + 2 * ahead(state) + SPARE
    return replace(state, settles=known, drifts=max(state.drifts, known), looks=max(state.looks, known))
