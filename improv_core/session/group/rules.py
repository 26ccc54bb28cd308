"""The rules for stages on several machines that play as one: `(group, event, now) -> (group, acts)`, without side
effects.

Each stage has the whole score and moves the robots of its host. A command for an instant is sent ahead of it, by as
long as the slowest message may take. Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, cast

from improv_core.ipc.stage_process import Heard
from improv_core.protocol.clock_messages import BendMessage
from improv_core.protocol.commands import COMMANDS, Pause, Resume, Stop
from improv_core.protocol.messages import Armed, FromStage, Load, Pressed, ToStage, TransportMessage
from improv_core.protocol.play_again import NOT_READY, STOPPED, stop_of
from improv_core.session.group import clock, shared_poses
from improv_core.session.group.acts import Act, Decided, Say, SendTo, StartHost, Times, warning
from improv_core.session.group.state import HERE, GroupState, beat_at
from improv_core.session.group.synced_start import (
    DRIFT_PERIOD,
    EARLY,
    begin,
    instant,
    playing_from,
    resume_at,
    settling,
)

CONFIRM_LIMIT = 1.0
"""Seconds within which stages confirm a stop. Then a line names the robots that may still be moving."""
CLOSE = 0.005
"""Seconds by which two stages' reports of the same instant may differ."""
MOST_PRESSES = 20
"""The counts of presses that are remembered. Hosts refuse a score that somebody asked for longer ago."""


def told(group: GroupState, message: ToStage, now: Times) -> Decided:
    """Take a message for all stages. Stops and pauses have been sent already: see `in_time`."""
    kind = message["type"]
    if message["type"] == "load":
        return _load(group, message, now)
    if message["type"] == "stop":
        if group.is_on:  # after a second stop, a stage that has yet to confirm the first one may still move
            group = group.with_all(group.alive, may_move=True)
        # New stages that have yet to play along: their robots may still move as the stages before left them.
        new = [host for host in {*group.joining, *group.entering} if not group.members[host].transport]
        stops = _halting(group, sorted(new))
        group = group.with_all(group.alive, armed=False).stopped()
        if "mark" in message:
            group = replace(group, unobeyed={**group.unobeyed, message["mark"]: group.to_obey})
        return replace(group, unconfirmed_at=min(group.unconfirmed_at, now.at + CONFIRM_LIMIT)), stops
    if message["type"] == "pause":
        group = group.without_entry()
        if group.mode == "playing":
            group = replace(group, mode="paused", paused_by=frozenset())
        elif group.mode != "paused":
            group = group.stopped()
        return group, []
    if message["type"] == "resume":
        return _resume(group, message, now)
    if message["type"] == "pressed":
        return group, [SendTo(host, _presses_of(group, host, message)) for host in group.alive]
    if message["type"] == "anchor" and group.clock:
        return clock.anchored(group, message, now)
    if kind not in COMMANDS:
        return group, [SendTo(HERE, message)] if HERE in group.alive else []  # for pages
    if COMMANDS[kind].kept:
        group = replace(group, kept={**group.kept, kind: message})
    acts = _all(group, in_time(group, message, now))
    if message["type"] == "seek" and group.enters < math.inf:
        group, entering = clock.enter(group, message["beat"], now)
        return group, [*acts, *entering]
    return settling(group, now), acts


def in_time(group: GroupState, message: Any, now: Times) -> Any:
    """Return a request with an instant by which all have received it. A stop takes effect at once."""
    if message["type"] == "stop" or group.mode != "playing":
        return message
    return {**message, "at": instant(group, now)}


def started(group: GroupState, host: str, now: Times) -> Decided:
    """Take the start or restart of a stage. If nothing plays, it stops robots that moved when the one before died."""
    halts = group.members[host].died_moving and not group.is_on
    fresh = replace(group.members[host], alive=True, armed=False, transport=None, may_move=False, died_moving=halts)
    group = replace(group, members={**group.members, host: replace(fresh, misplaced={})})
    kept: list[Act] = [SendTo(host, message) for message in group.kept.values()]
    # The stage before it stopped its robots when it ended, or this one reports when it has stopped them.
    group, told = (group, []) if halts else _obeyed(group, host, group.unobeyed)
    group, acts = _join(group, host, now)
    if halts:
        acts = _halting(group, [host])
    return group, [*kept, *told, *acts]


def said(group: GroupState, host: str, message: Heard, now: Times) -> Decided:
    """Take a message from a stage."""
    if host not in group.alive:
        return group, []
    if message["type"] == "transport":
        return _transport(group, host, message, now)
    if message["type"] == "armed":
        return _armed(group.with_member(host, armed=message["armed"]), host, message, now)
    if message["type"] == "obeyed":
        return _obeyed(group, host, [message["mark"]])
    if message["type"] == "lacks":
        is_sent = message["generation"] <= group.entering.get(host, -1)
        return (group, []) if is_sent else _join(group, host, now)
    if message["type"] == "deserted":
        line = f"{host} heard nothing from here for {message['seconds']:g} s, so its robots stopped"
        if group.is_on and any(each != host for each in group.playing):
            group, acts = _join(group, host, now)
            return group, [warning(f"{line}; they join the others again"), *acts]
        return group, [warning(f"{line}: play again")]
    if message["type"] == "gone":
        return _gone(group, host, message["message"])
    if message["type"] == "misplaced":
        group = group.with_member(host, misplaced=message["robots"])
        robots = {robot: each for member in group.members.values() for robot, each in member.misplaced.items()}
        return group, [Say({**message, "robots": robots})]
    if message["type"] == "pressed":
        return _pressed(group.with_member(host, pressed=message))
    if message["type"] == "seen":
        return shared_poses.seen(group, host, message, now)
    if message["type"] == "link":
        return group.with_member(host, lag=message["lag"]), [Say(message)]
    if message["type"] == "warning" and "too_near" in message and group.repeats(host):
        return group, []
    if message["type"] == "warning" or message["type"] == "error":
        line = f"{host}: {message['message']}" if host else message["message"]
        return group, [Say(cast(FromStage, {**message, "message": line}))]
    if message["type"] == "stopped":
        return group, []
    if message["type"] == "vitals":
        ours = {robot: each for robot, each in message["robots"].items() if group.owns(host, robot)}
        group = group.with_member(host, vitals=ours)
        known = {robot: each for member in group.members.values() for robot, each in member.vitals.items()}
        return group, [Say({**message, "robots": known})]
    return group, _pass_on(group, host, message)


def waited(group: GroupState, now: Times) -> Decided:
    """Do what is due at a time that `due` named."""
    acts: list[Act] = []
    if now.at >= group.unconfirmed_at:
        group, acts = unconfirmed(group)
    if now.at >= group.drifts:
        group = replace(group, drifts=now.at + DRIFT_PERIOD)
        acts += _share_position(group, now)
    if group.mode == "armed" and now.wall >= group.opens - EARLY:
        group, more = begin(group, now.at + max(group.opens - now.wall, group.ahead))
        acts += more
    group, entered = clock.waited(group, now)
    if now.at >= group.settles:
        group = replace(group, settles=-math.inf)
    group, admitted = _admit(group, now)
    group, passed = shared_poses.passed_on(group, now)
    return group, [*acts, *entered, *admitted, *passed]


def unconfirmed(group: GroupState) -> Decided:
    """Name the robots that may still move after a stop, if people wait for its confirmation."""
    if group.unconfirmed_at == math.inf:
        return group, []
    group = replace(group, unconfirmed_at=math.inf)
    hosts = [host for host in group.members if group.members[host].may_move]
    robots = [robot for host in hosts for robot in group.of(host)]
    if not robots:
        return group, []
    line = f"{', '.join(robots)} may still be moving: {', '.join(hosts)} has not confirmed the stop"
    return group, [Say({"type": "unreached", "generation": group.generation, "robots": robots, "message": line})]


def due(group: GroupState, now: Times) -> float:
    """Return the time of the next call of `waited`, in monotonic seconds; infinite if there is none."""
    begins = now.at + group.opens - EARLY - now.wall if group.mode == "armed" else math.inf
    drifts = group.drifts if group.mode == "playing" else math.inf
    settles = group.settles if group.joining and group.settles > -math.inf else math.inf
    return min(group.unconfirmed_at, begins, drifts, settles, clock.due(group), shared_poses.due(group))


def _load(group: GroupState, load: Load, now: Times) -> Decided:
    if not group.may_start(load.get("by")):
        return group, [warning(STOPPED)]
    continues = load["when"] != "restart" and group.mode in ("playing", "paused")
    group, load, told = clock.taken(group, load)
    group = group.loading(load)
    lost = group.of(HERE) if HERE not in group.alive else []
    line = f"nobody moves {', '.join(lost)}: no ROS 2 runs here, and they have no `host`"
    told += [warning(line)] if lost else []
    if continues:
        if group.mode == "paused":  # each continues as soon as it has this, so they soon need the lead's position
            group = replace(playing_from(group, now.at), drifts=now.at)
        at: Load = {**load, "at": instant(group, now)} if group.mode == "playing" else load
        sent = [SendTo(host, group.load_for(host, at)) for host in group.alive if host not in group.joining]
        return settling(group, now), [*told, *sent]
    arming = load.get("arming")
    begins = arming.get("begins", math.inf) if arming is not None else math.inf
    group = replace(group, arming=arming, begins=begins, anyway=load.get("anyway", False), paused_by=frozenset())
    group, acts = _gather(group, load)
    return group, [*told, *acts]


def _gather(group: GroupState, load: Load) -> Decided:
    """Have all get ready for beat 0."""
    # `arming` keeps a stage from playing that has sought a beat after a stop.
    whole: Load = {**load, "when": "restart", "arming": {}}
    if group.anyway:
        whole["anyway"] = True
    fresh = group.without_entry().with_all(group.alive, armed=False, misplaced={}, died_moving=False)
    group = replace(fresh, mode="gathering", joining=frozenset(), entering={})
    return group, [SendTo(host, group.load_for(host, whole)) for host in group.alive]


def _join(group: GroupState, host: str, now: Times) -> Decided:
    """Have a stage that doesn't play yet join: at once if the others play, otherwise as soon as they do."""
    if not group.is_on:
        return group, []
    led = group.lead == host
    group = group.without(host).with_member(host, armed=False)
    group = replace(group, joining=group.joining | {host})
    leads: list[Act] = [Say(group.position)] if led and group.position else []
    group, acts = _admit(group, now)
    return group, [*leads, *acts]


def _admit(group: GroupState, now: Times) -> Decided:
    """Have the stages that wait to join play along, if that is possible now."""
    if group.load is None or not group.joining:
        return group, []
    hosts, presses = sorted(group.joining), {host: member.pressed["count"] for host, member in group.members.items()}
    load: Load = {**group.load, "when": "restart"}
    if group.mode in ("gathering", "armed"):
        load["arming"] = {}
        group = replace(group, mode="gathering")
    elif group.mode == "playing" and now.at >= group.settles and (entry := group.entry_at(instant(group, now))):
        load["entry"] = entry
        group = replace(group, entering={**group.entering, **dict.fromkeys(hosts, group.generation)})
    else:
        return group, []
    group = replace(group, joining=frozenset())
    # Somebody asked for the score earlier, and nobody has stopped it: so each may know of all presses it has received.
    return group, [SendTo(host, {**group.load_for(host, load), "stops": presses[host]}) for host in hosts]


def _halting(group: GroupState, hosts: Iterable[str]) -> list[Act]:
    """Have stages stop their robots, even if they have yet to find them."""
    return [SendTo(host, group.load_for(host, _standing(group.load))) for host in hosts] if group.load else []


def _standing(load: Load) -> Load:
    """Return a score whose robots only have to stop."""
    parts = {robot: {**part, "scenes": [], "reset": None} for robot, part in load["score"]["parts"].items()}
    score = {**load["score"], "movements": [], "parts": parts}  # nothing can build on it: the next score is sent whole
    standing: Load = {
        "type": "load",
        "generation": load["generation"],
        "score": score,
        "when": "restart",
        "backend": load["backend"],
    }
    return standing


def _resume(group: GroupState, resume: Resume, now: Times) -> Decided:
    anyway, position = resume.get("anyway", False), group.position
    if not group.may_start(resume.get("by")):
        return group, [warning(STOPPED)]
    if group.mode == "gathering":
        return group, [warning(NOT_READY)]
    if group.mode in ("armed", "paused") and group.clock and group.clock.stands:
        return replace(group, stands=True), []  # the clock has to continue first
    if group.mode == "armed":
        return clock.enter(group, 0.0, now) if group.is_led else begin(group, now.at + group.ahead)
    if group.mode == "unplaced":
        return _gather(replace(group, anyway=anyway), group.load) if group.load else (group, [])
    if group.mode == "stopped" and position and position["state"] == "paused":
        # Somebody has sought since the stop: they continue from there, and stages that could not seek join them.
        apart = {host for host in group.alive if not (said := group.members[host].transport) or said.get("deserted")}
        group = replace(group, mode="paused", joining=frozenset(apart))
    if position is None or group.mode != "paused":
        return group, []
    if group.is_led and not anyway:
        return clock.enter(group, position["beat"], now)
    # The lead may have yet to report that it has paused.
    return resume_at(group, group.alive, beat_at(position, now.at), now.at + group.ahead, resume)


def _armed(group: GroupState, host: str, said: Armed, now: Times) -> Decided:
    """Take a stage's report that it is ready for beat 0, or no longer. Once all have been sent the time to begin, the
    lead reports when it counts, and that it has begun."""
    ready = all(group.members[host].armed for host in group.alive)
    if group.mode == "gathering" and ready:
        if group.arming is None:
            return clock.ready(group, now) if group.clock else begin(group, now.at + group.ahead)
        begins = group.begins if group.begins < math.inf else None
        armed: Armed = {"type": "armed", "generation": group.generation, "armed": True, "begins": begins}
        if begins and group.count:
            armed["count"] = group.count
        return replace(group, mode="armed"), [Say(armed)]
    if group.mode == "armed" and not ready:
        not_armed: Armed = {"type": "armed", "generation": group.generation, "armed": False, "begins": None}
        return replace(group.without_entry(), mode="gathering"), [Say(not_armed)]
    if group.mode not in ("gathering", "armed") and host == group.lead:
        return group, [Say(said)]
    return group, []


def _transport(group: GroupState, host: str, transport: TransportMessage, now: Times) -> Decided:
    state, before = transport["state"], group.members[host].transport
    if group.members[host].died_moving:  # it only stops robots, whatever it reports about that
        if state not in ("stopped", "ended"):
            return group, []
        return _obeyed(group.with_member(host, died_moving=False), host, group.unobeyed)
    moves = state in ("playing", "waiting")
    group = group.with_member(host, transport=transport, may_move=group.members[host].may_move and moves)
    if transport["generation"] >= group.entering.get(host, math.inf) and not transport.get("deserted"):
        group = replace(group, entering={each: sent for each, sent in group.entering.items() if each != host})
    by_lead: list[Act] = [Say(transport)] if host == group.lead else []
    if by_lead and state == "playing" and group.mode == "playing":
        group, acts = _admit(group, now)
        by_lead += acts
    if moves and not group.is_on and before is not None and before["state"] in ("stopped", "paused"):
        stray: Stop = {"type": "stop"}
        return group.with_member(host, may_move=True), [*by_lead, SendTo(host, stray)]  # all had been stopped
    # Before all begin, reports about an earlier score are old. While they play, a stage that stops may have yet to take
    # over a score that was saved a moment ago.
    is_old = transport["generation"] != group.generation
    if host not in group.playing or (is_old and not (state == "stopped" and group.mode in ("playing", "paused"))):
        return group, by_lead
    if transport.get("too_near"):
        group = group.without_entry()  # a person has to make room, whatever a clock does
    if state == "stopped" and group.is_on:  # it has its reasons: an emergency stop, or it couldn't keep up
        others = group.others(host)
        group = replace(group.stopped().with_all(others, may_move=True), unconfirmed_at=now.at + CONFIRM_LIMIT)
        return group, [*(SendTo(each, stop_of(transport)) for each in others), Say(transport)]
    if state == "paused" and group.mode in ("gathering", "armed"):
        return replace(group, mode="unplaced"), [Say(transport)]
    was_paused = before is not None and before["state"] == "paused"
    is_old = (was_paused or transport["monotonic"] < group.since + CLOSE) and not transport.get("waits_for")
    if state == "paused" and group.mode == "playing" and is_old:
        # It has sought the beat from which all continue, or reports its pause late. Of two robots that come too near to
        # each other, each is paused by its own stage, and the second report may come after a person resumes.
        return group, []
    if state == "paused" and group.mode == "playing":
        others = group.others(host)
        pause: Pause = {"type": "pause"}
        group = replace(group, mode="paused", paused_by=frozenset({host}), paused_first=host)
        return group, [*(SendTo(each, pause) for each in others), Say(transport)]
    if state == "paused" and group.mode == "paused" and _waits(transport):
        return replace(group, paused_by=group.paused_by | {host}), [Say(transport)]
    if state == "playing" and group.mode == "paused" and host in group.paused_by:
        return _continue_with(group, host, transport, now)
    if state == "ended" and host == group.lead:
        by_lead += _stop_entering(group)
        group = group.stopped()
    group, joins = _share_scene(group, host, now)
    return group, [*by_lead, *joins]


def _share_scene(group: GroupState, host: str, now: Times) -> Decided:
    """Have stages join the lead if they began a scene at another beat: some news of its end came late."""
    acts: list[Act] = []
    for each in group.others(host) if host == group.lead else [host]:
        if group.mode == "playing" and each in group.playing and group.is_apart(each):
            group, more = _join(group.with_member(each, transport=None), each, now)
            acts += more
    return group, acts


def _continue_with(group: GroupState, host: str, transport: TransportMessage, now: Times) -> Decided:
    """Have the others continue with a stage that had paused and continues by itself, unless another one still waits."""
    others = group.others(host)
    left = group.paused_by - {host}
    if left:
        pause: Pause = {"type": "pause"}
        return replace(group, paused_by=left), [SendTo(host, pause)]
    at = now.at + group.ahead
    group, acts = resume_at(group, others, beat_at(transport, at), at)
    return group, [*acts, Say(transport)]


def _gone(group: GroupState, host: str, why: str) -> Decided:
    led, member = group.lead == host, group.members[host]
    before = member.transport
    reported = before is not None and before["state"] in ("playing", "waiting")
    moved = reported or member.may_move or member.died_moving
    group = group.with_member(host, alive=False, armed=False, may_move=False, died_moving=moved)
    group = group.without(host)
    if not group.alive:
        return replace(group, mode="stopped"), [Say({"type": "gone", "message": why})]
    continues = group.is_on and group.lead is not None
    line = f"{host or 'the stage here'}: {why}"
    acts: list[Act] = [
        warning(f"{line}; the others continue, and it joins them again" if continues else line),
        StartHost(host),
    ]
    if continues and led and (position := group.position):
        acts.append(Say(position))
    if group.is_on and not continues:
        acts += _stop_entering(group)
        group = group.stopped()
        acts += [Say({**before, "state": "stopped"})] if before else []
    return group, acts


def _stop_entering(group: GroupState) -> list[Act]:
    """Stop the stages that were sent the score of the others: that has ended."""
    stop: Stop = {"type": "stop"}
    return [SendTo(host, stop) for host in sorted(group.entering)]


def _obeyed(group: GroupState, host: str, marks: Iterable[str]) -> Decided:
    """Note that the stage of a host has obeyed these stops, and report which have yet to."""
    acts: list[Act] = []
    for mark in [*marks]:
        if host in group.unobeyed.get(mark, ()):
            left = group.unobeyed[mark] - {host}
            rest = {other: hosts for other, hosts in group.unobeyed.items() if other != mark}
            group = replace(group, unobeyed={**rest, mark: left} if left else rest)
            waits = [each or "the stage here" for each in sorted(left)]
            acts.append(Say({"type": "obeyed", "mark": mark, "waits_for": waits}))
    return group, acts


def _pressed(group: GroupState) -> Decided:
    """Report the emergency stops that are on, on any host."""
    counts = {host: member.pressed["count"] for host, member in group.members.items()}
    topics = sorted({topic for member in group.members.values() for topic in member.pressed["topics"]})
    kept = dict([*group.presses.items(), (sum(counts.values()), counts)][-MOST_PRESSES:])
    pressed: Pressed = {"type": "pressed", "topics": topics, "count": sum(counts.values())}
    return replace(group, presses=kept), [Say(pressed)]


def _presses_of(group: GroupState, host: str, pressed: Pressed) -> Pressed:
    return {**pressed, "count": group.presses.get(pressed["count"], {}).get(host, pressed["count"])}


def _pass_on(group: GroupState, host: str, message: FromStage) -> list[Act]:
    """Pass on a stage's message about its robots. All stages get what they sense, since that decides when scenes
    begin."""
    if message["type"] == "measured":
        ours = {robot: each for robot, each in message["robots"].items() if group.owns(host, robot)}
        return [Say({**message, "robots": ours})] if ours else []
    robot = message.get("robot")
    if isinstance(robot, str) and not group.owns(host, robot):
        return []
    acts: list[Act] = [Say(message)]
    if message["type"] == "sensed":
        acts += [SendTo(other, message) for other in group.others(host)]
    return acts


def _share_position(group: GroupState, now: Times) -> list[Act]:
    """Send the lead's position to the others."""
    position = group.position
    if position is None or position["state"] != "playing":
        return []
    beat, pace = beat_at(position, now.at), position.get("pace", 1.0)
    bend: BendMessage = {"type": "bend", "at": now.at, "beat": beat, "pace": pace}
    return [SendTo(host, bend) for host in group.alive if host != group.lead and host not in group.joining]


def _waits(transport: TransportMessage) -> bool:
    return bool(transport.get("waits_for") or transport.get("too_near"))


def _all(group: GroupState, message: ToStage) -> list[Act]:
    return [SendTo(host, message) for host in group.alive]
