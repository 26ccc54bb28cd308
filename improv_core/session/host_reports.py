"""Decides about what the stages of real robots on several machines report: `(state, host, message, now) ->
(state, acts)`, without side effects. Standard library only.

They report as one: `on_report` takes each announcement like the report of a single stage.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeVar, cast

from improv_core.ipc.stage_process import Heard
from improv_core.protocol.messages import Armed, FromStage, TransportMessage
from improv_core.protocol.transport import plays, stop_of
from improv_core.session import clock, together
from improv_core.session.acts import Act, Announce, Now, Start, StateAndActs, send, warning
from improv_core.session.halting import halt, has_halted, stand, stood
from improv_core.session.on_hosts import CONFIRM_LIMIT, admit, join, pass_on_seen
from improv_core.session.state import SessionState, StageKey
from improv_core.session.together import SPARE, begin, resume_at

T = TypeVar("T")

CLOSE = 0.005
"""Seconds by which two stages' reports of the same instant may differ."""
MAX_PRESSES = 20
"""The counts of presses that are remembered. Hosts refuse a score that somebody asked for longer ago."""


def reported(state: SessionState, host: str, message: Heard, now: Now) -> StateAndActs:
    if host not in state.alive:
        return state, []
    match message["type"]:
        case "transport":
            return _transport(state, host, message, now)
        case "armed":
            return _armed(together.with_all(state, [host], armed=message["armed"]), host, message, now)
        case "lacks":
            is_sent = message["generation"] <= state.entering.get(host, -1)
            return (state, []) if is_sent else join(state, host, now)
        case "deserted":
            line = f"{host} heard nothing from here for {message['seconds']:g} s, so its robots stopped"
            if state.mode == "stopped" or not any(each != host for each in together.playing(state)):
                return state, [warning(f"{line}: play again")]
            state, acts = join(state, host, now)
            return state, [warning(f"{line}; they join the others again"), *acts]
        case "gone":
            return _gone(state, host, message["message"], now)
        case "misplaced":
            state = together.with_all(state, [host], misplaced=message["robots"])
            return state, [Announce({**message, "robots": _all(stage.misplaced for stage in state.robots.values())})]
        case "pressed":
            return _pressed(together.with_all(state, [host], pressed=message))
        case "seen":
            ours = _ours(state, host, message["robots"])
            return pass_on_seen(replace(state, seen={**state.seen, **ours}), now)
        case "link":
            return together.with_all(state, [host], lag=message["lag"] + SPARE), [Announce(message)]
        case "warning" if "too_near" in message and together.repeats(state, host):
            return state, []
        case "warning" | "error":
            line = f"{host}: {message['message']}" if host else message["message"]
            return state, [Announce(cast(FromStage, {**message, "message": line}))]
        case "stopped":
            return state, []
        case "vitals":
            state = together.with_all(state, [host], vitals=_ours(state, host, message["robots"]))
            return state, [Announce({**message, "robots": _all(stage.vitals for stage in state.robots.values())})]
        case "measured":
            robots = _ours(state, host, message["robots"])
            return state, [Announce({**message, "robots": robots})] if robots else []
        case _:
            robot = message.get("robot")
            if isinstance(robot, str) and together.host_of(state, robot) != host:
                return state, []
            # All stages get what robots sense, since that decides when scenes begin.
            others = together.others(state, host) if message["type"] == "sensed" else []
            return state, [Announce(message), *(send(other, cast(Any, message)) for other in others)]


def _armed(state: SessionState, host: str, said: Armed, now: Now) -> StateAndActs:
    """Take a stage's report that it is ready for beat 0, or no longer. Once all have been sent the time to begin, the
    lead reports when it counts, and that it has begun."""
    ready = all(state.robots[host].armed for host in state.alive)
    if state.mode == "gathering" and ready:
        if state.on_robots.arming is None:
            return clock.ready(state, now) if state.following else begin(state, now.at + together.ahead(state))
        begins, count = together.begins(state), together.count(state)
        armed: Armed = {"type": "armed", "generation": state.generation, "armed": True, "begins": None}
        if begins < math.inf:
            armed["begins"] = begins
            if count:
                armed["count"] = count
        return replace(state, mode="armed"), [Announce(armed)]
    if state.mode == "armed" and not ready:
        not_armed: Armed = {"type": "armed", "generation": state.generation, "armed": False, "begins": None}
        return replace(together.without_entry(state), mode="gathering"), [Announce(not_armed)]
    if state.mode not in ("gathering", "armed") and host == together.lead(state):
        return state, [Announce(said)]
    return state, []


def _transport(state: SessionState, host: str, transport: TransportMessage, now: Now) -> StateAndActs:
    kind, before = transport["state"], state.robots[host].transport
    if state.robots[host].died_moving:  # it only stops robots, whatever it reports about that
        stands = has_halted(state, StageKey(host, "ros"), transport)
        state = together.with_all(state, [host], died_moving=not stands)
        return state, stand(state, StageKey(host, "ros"), now) if stands else []
    moves = plays(transport)
    may_move = state.robots[host].may_move and moves
    state = together.with_all(state, [host], transport=transport, may_move=may_move)
    if transport["generation"] >= state.entering.get(host, math.inf) and not transport.get("deserted"):
        state = replace(state, entering={each: sent for each, sent in state.entering.items() if each != host})
    by_lead: list[Act] = [Announce(transport)] if host == together.lead(state) else []
    if by_lead and kind == "playing" and state.mode == "playing":
        state, acts = admit(state, now)
        by_lead += acts
    if moves and state.mode == "stopped" and before is not None and before["state"] in ("stopped", "paused"):
        state = together.with_all(state, [host], may_move=True)
        return state, [*by_lead, send(host, {"type": "stop"})]  # all had been stopped
    # Before all begin, reports about an earlier score are old. While they play, a stage that stops may have yet to take
    # over a score that was saved a moment ago.
    is_old = transport["generation"] != state.generation
    if host not in together.playing(state) or (
        is_old and not (kind == "stopped" and state.mode in ("playing", "paused"))
    ):
        return state, by_lead
    if transport.get("too_near"):
        state = together.without_entry(state)  # a person has to make room, whatever a clock does
    others = together.others(state, host)
    if kind == "stopped" and state.mode != "stopped":  # it has its reasons: an emergency stop, or it couldn't keep up
        state = together.with_all(together.stopped(state), others, may_move=True)
        state = replace(state, unconfirmed_at=now.at + CONFIRM_LIMIT)
        return state, [*(send(each, stop_of(transport)) for each in others), Announce(transport)]
    if kind == "paused" and state.mode in ("gathering", "armed"):
        return replace(state, mode="unplaced"), [Announce(transport)]
    if kind == "paused" and state.mode == "playing":
        was_paused = before is not None and before["state"] == "paused"
        if (was_paused or transport["monotonic"] < state.since + CLOSE) and not transport.get("waits_for"):
            # It has sought the beat from which all continue, or reports its pause late. Of two robots that come too
            # near to each other, each is paused by its own stage, and the second report may come after a person
            # resumes.
            return state, []
        state = replace(state, mode="paused", paused_by=frozenset({host}), paused_first=host)
        return state, [*(send(each, {"type": "pause"}) for each in others), Announce(transport)]
    if kind == "paused" and state.mode == "paused" and (transport.get("waits_for") or transport.get("too_near")):
        return replace(state, paused_by=state.paused_by | {host}), [Announce(transport)]
    if kind == "playing" and state.mode == "paused" and host in state.paused_by:
        return _continue_with(state, host, transport, now)
    if kind == "ended" and host == together.lead(state):
        by_lead += _stop_entering(state)
        state = together.stopped(state)
    state, joins = _share_scene(state, host, now)
    return state, [*by_lead, *joins]


def _share_scene(state: SessionState, host: str, now: Now) -> StateAndActs:
    """Have stages join the lead if they began a scene at another beat: some news of its end came late."""
    acts: list[Act] = []
    for each in together.others(state, host) if host == together.lead(state) else [host]:
        if state.mode == "playing" and each in together.playing(state) and together.is_apart(state, each):
            state, more = join(together.with_all(state, [each], transport=None), each, now)
            acts += more
    return state, acts


def _continue_with(state: SessionState, host: str, transport: TransportMessage, now: Now) -> StateAndActs:
    """Have the others continue with a stage that had paused and continues by itself, unless another one still waits."""
    left = state.paused_by - {host}
    if left:
        return replace(state, paused_by=left), [send(host, {"type": "pause"})]
    at = now.at + together.ahead(state)
    state, acts = resume_at(state, together.others(state, host), together.beat_at(transport, at), at)
    return state, [*acts, Announce(transport)]


def _gone(state: SessionState, host: str, why: str, now: Now) -> StateAndActs:
    """Have the others continue without a stage that has died. If none of them plays yet, they only stop robots."""
    led, stage = together.lead(state) == host, state.robots[host]
    before = stage.transport
    reported = before is not None and plays(before)
    moved = bool(state.editions.sent) and (reported or stage.may_move or stage.died_moving)
    state = together.with_all(state, [host], alive=False, armed=False, may_move=False, died_moving=moved)
    state = together.without(state, host)
    continues = state.mode != "stopped" and together.lead(state) is not None
    line = f"{host or 'the stage here'}: {why}"
    acts: list[Act] = [
        warning(f"{line}; the others continue, and it joins them again" if continues else line),
        Start(StageKey(host, "ros")),
    ]
    if continues and led and (lead := together.position(state)):
        acts.append(Announce(lead))
    if state.mode != "stopped" and not continues:
        acts += _stop_entering(state)
        state = together.stopped(replace(state, stood=stood(state, now)))
        state = together.with_all(state, state.alive, transport=None, died_moving=True, only_halts=True)
        acts += [halt(state, StageKey(each, "ros")) for each in state.alive]
        acts += [Announce({**before, "state": "stopped"})] if before else []
    return state, acts


def _stop_entering(state: SessionState) -> list[Act]:
    """Stop the stages that were sent the score of the others: that has ended."""
    return [send(host, {"type": "stop"}) for host in sorted(state.entering)]


def _pressed(state: SessionState) -> StateAndActs:
    """Report the emergency stops that are on, on any host."""
    counts = {host: stage.pressed["count"] for host, stage in state.robots.items()}
    topics = sorted({topic for stage in state.robots.values() for topic in stage.pressed["topics"]})
    kept = dict([*state.presses.items(), (sum(counts.values()), counts)][-MAX_PRESSES:])
    return replace(state, presses=kept), [
        Announce({"type": "pressed", "topics": topics, "count": sum(counts.values())})
    ]


def _ours(state: SessionState, host: str, robots: Mapping[str, T]) -> dict[str, T]:
    """Return what a stage reports about its own robots. It can't know about others."""
    return {robot: each for robot, each in robots.items() if together.host_of(state, robot) == host}


def _all(known: Iterable[Mapping[str, T]]) -> dict[str, T]:
    return {robot: each for robots in known for robot, each in robots.items()}
