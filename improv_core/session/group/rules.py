"""How stages on several machines play as one: `(troupe, event, now) -> (troupe, acts)`. Nothing here does anything.

Each has the whole score and moves the robots of its host. What they are to do at an instant is sent ahead of it, by as
long as the slowest message may take. Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from typing import Any, cast

from improv_core.ipc.stage_process import Heard
from improv_core.protocol.clock_messages import BendMessage
from improv_core.protocol.commands import COMMANDS, Anyway, Pause, Resume, Stop
from improv_core.protocol.messages import Armed, FromStage, Load, Pressed, ToStage, TransportMessage
from improv_core.protocol.play_again import STOPPED, stop_of
from improv_core.session.group import clock, shared_poses
from improv_core.session.group.acts import Act, Decided, Say, SendTo, StartHost, Times, warning
from improv_core.session.group.state import HERE, Troupe, beat_at
from improv_core.session.group.synced_start import DRIFT_PERIOD, EARLY, begin, go, going_on, instant, settling

CONFIRM_LIMIT = 1.0
"""Seconds that a stop may take to be confirmed. Then people are told which robots may still be moving."""
CLOSE = 0.005
"""Seconds by which two stages may tell the same instant differently."""
MOST_PRESSES = 20
"""Counts of presses that are remembered. A score that somebody asked for longer ago is refused by hosts."""
NOT_READY = "not begun: robots are still waited for; begin once it says `armed`"


def told(troupe: Troupe, message: ToStage, now: Times) -> Decided:
    """What follows from what all are told. Stops and pauses have been sent already: see `in_time`."""
    kind = message["type"]
    if message["type"] == "load":
        return _load(troupe, message, now)
    if message["type"] == "stop":
        if troupe.is_on:  # after a second stop, who has yet to confirm the first one may still move
            troupe = troupe.with_all(troupe.alive, may_move=True)
        troupe = troupe.with_all(troupe.alive, armed=False).stopped()
        if "mark" in message:
            troupe = replace(troupe, unobeyed={**troupe.unobeyed, message["mark"]: troupe.to_obey})
        return replace(troupe, unconfirmed_at=min(troupe.unconfirmed_at, now.at + CONFIRM_LIMIT)), []
    if message["type"] == "pause":
        troupe = troupe.without_entry()
        if troupe.mode == "playing":
            troupe = replace(troupe, mode="paused", paused_by=frozenset())
        elif troupe.mode != "paused":
            troupe = troupe.stopped()
        return troupe, []
    if message["type"] == "resume" or message["type"] == "anyway":
        return _resume(troupe, message, now)
    if message["type"] == "pressed":
        return troupe, [SendTo(host, _presses_of(troupe, host, message)) for host in troupe.alive]
    if message["type"] == "anchor" and troupe.clock:
        return clock.anchored(troupe, message, now)
    if kind not in COMMANDS:
        return troupe, [SendTo(HERE, message)] if HERE in troupe.alive else []  # for pages
    if COMMANDS[kind].kept:
        troupe = replace(troupe, kept={**troupe.kept, kind: message})
    acts = _all(troupe, in_time(troupe, message, now))
    if message["type"] == "seek" and troupe.enters < math.inf:
        troupe, entering = clock.enter(troupe, message["beat"], now)
        return troupe, [*acts, *entering]
    return settling(troupe, now), acts


def in_time(troupe: Troupe, message: Any, now: Times) -> Any:
    """What is asked of all, for an instant at which all have heard it. A stop is for now."""
    if message["type"] == "stop" or troupe.mode != "playing":
        return message
    return {**message, "at": instant(troupe, now)}


def started(troupe: Troupe, host: str, now: Times) -> Decided:
    """A stage has started, or started again. If nothing plays, it stops robots that moved when the one before died."""
    halts = troupe.members[host].died_moving and not troupe.is_on
    fresh = replace(troupe.members[host], alive=True, armed=False, transport=None, may_move=False, died_moving=halts)
    troupe = replace(troupe, members={**troupe.members, host: replace(fresh, misplaced={})})
    kept: list[Act] = [SendTo(host, message) for message in troupe.kept.values()]
    # The stage before it stopped its robots when it ended, or this one says when it has stopped them.
    troupe, told = (troupe, []) if halts else _obeyed(troupe, host, troupe.unobeyed)
    troupe, acts = _join(troupe, host, now)
    if halts and troupe.load:
        acts = [SendTo(host, troupe.load_for(host, _standing(troupe.load)))]
    return troupe, [*kept, *told, *acts]


def said(troupe: Troupe, host: str, message: Heard, now: Times) -> Decided:
    """What follows from what a stage says."""
    if host not in troupe.alive:
        return troupe, []
    if message["type"] == "transport":
        return _transport(troupe, host, message, now)
    if message["type"] == "armed":
        return _armed(troupe.with_member(host, armed=message["armed"]), host, message, now)
    if message["type"] == "obeyed":
        return _obeyed(troupe, host, [message["mark"]])
    if message["type"] == "lacks":
        is_sent = message["generation"] <= troupe.entering.get(host, -1)
        return (troupe, []) if is_sent else _join(troupe, host, now)
    if message["type"] == "deserted":
        line = f"{host} heard nothing from here for {message['seconds']:g} s, so its robots stopped"
        if troupe.is_on and any(each != host for each in troupe.playing):
            troupe, acts = _join(troupe, host, now)
            return troupe, [warning(f"{line}; they join the others again"), *acts]
        return troupe, [warning(f"{line}: play again")]
    if message["type"] == "gone":
        return _gone(troupe, host, message["message"])
    if message["type"] == "misplaced":
        troupe = troupe.with_member(host, misplaced=message["robots"])
        robots = {robot: each for member in troupe.members.values() for robot, each in member.misplaced.items()}
        return troupe, [Say({**message, "robots": robots})]
    if message["type"] == "pressed":
        return _pressed(troupe.with_member(host, pressed=message))
    if message["type"] == "seen":
        return shared_poses.seen(troupe, host, message, now)
    if message["type"] == "link":
        return troupe.with_member(host, lag=message["lag"]), [Say(message)]
    if message["type"] == "warning" and "too_near" in message and troupe.repeats(host):
        return troupe, []
    if message["type"] == "warning" or message["type"] == "error":
        line = f"{host}: {message['message']}" if host else message["message"]
        return troupe, [Say(cast(FromStage, {**message, "message": line}))]
    if message["type"] == "stopped":
        return troupe, []
    if message["type"] == "vitals":
        ours = {robot: each for robot, each in message["robots"].items() if troupe.owns(host, robot)}
        troupe = troupe.with_member(host, vitals=ours)
        known = {robot: each for member in troupe.members.values() for robot, each in member.vitals.items()}
        return troupe, [Say({**message, "robots": known})]
    return troupe, _about_robots(troupe, host, message)


def waited(troupe: Troupe, now: Times) -> Decided:
    """What follows once a time has come that `due` named."""
    acts: list[Act] = []
    if now.at >= troupe.unconfirmed_at:
        troupe, acts = unconfirmed(troupe)
    if now.at >= troupe.drifts:
        troupe = replace(troupe, drifts=now.at + DRIFT_PERIOD)
        acts += _where_it_is(troupe, now)
    if troupe.mode == "armed" and now.wall >= troupe.opens - EARLY:
        troupe, more = begin(troupe, now.at + max(troupe.opens - now.wall, troupe.ahead))
        acts += more
    troupe, entered = clock.waited(troupe, now)
    if now.at >= troupe.settles:
        troupe = replace(troupe, settles=-math.inf)
    troupe, admitted = _admit(troupe, now)
    troupe, passed = shared_poses.passed_on(troupe, now)
    return troupe, [*acts, *entered, *admitted, *passed]


def unconfirmed(troupe: Troupe) -> Decided:
    """Name the robots that may still move after a stop, if people wait for that to be confirmed."""
    if troupe.unconfirmed_at == math.inf:
        return troupe, []
    troupe = replace(troupe, unconfirmed_at=math.inf)
    hosts = [host for host in troupe.members if troupe.members[host].may_move]
    robots = [robot for host in hosts for robot in troupe.of(host)]
    if not robots:
        return troupe, []
    line = f"{', '.join(robots)} may still be moving: {', '.join(hosts)} has not confirmed the stop"
    return troupe, [Say({"type": "unreached", "generation": troupe.generation, "robots": robots, "message": line})]


def due(troupe: Troupe, now: Times) -> float:
    """When `waited` is to be called, in monotonic seconds; infinite if nothing is waited for."""
    begins = now.at + troupe.opens - EARLY - now.wall if troupe.mode == "armed" else math.inf
    drifts = troupe.drifts if troupe.mode == "playing" else math.inf
    settles = troupe.settles if troupe.joining and troupe.settles > -math.inf else math.inf
    return min(troupe.unconfirmed_at, begins, drifts, settles, clock.due(troupe), shared_poses.due(troupe))


def _load(troupe: Troupe, load: Load, now: Times) -> Decided:
    if not troupe.may_start(load.get("by")):
        return troupe, [warning(STOPPED)]
    goes_on = load["when"] != "restart" and troupe.mode in ("playing", "paused")
    troupe, load, told = clock.taken(troupe, load)
    troupe = troupe.loading(load)
    lost = troupe.of(HERE) if HERE not in troupe.alive else []
    line = f"nobody moves {', '.join(lost)}: no ROS 2 runs here, and they have no `host`"
    told += [warning(line)] if lost else []
    if goes_on:
        if troupe.mode == "paused":  # each goes on as soon as it has this, so they are told soon where the lead is
            troupe = replace(going_on(troupe, now.at), drifts=now.at)
        at: Load = {**load, "at": instant(troupe, now)} if troupe.mode == "playing" else load
        sent = [SendTo(host, troupe.load_for(host, at)) for host in troupe.alive if host not in troupe.joining]
        return settling(troupe, now), [*told, *sent]
    arming = load.get("arming")
    begins = arming.get("begins", math.inf) if arming is not None else math.inf
    troupe = replace(troupe, arming=arming, begins=begins, anyway=load.get("anyway", False), paused_by=frozenset())
    troupe, acts = _gather(troupe, load)
    return troupe, [*told, *acts]


def _gather(troupe: Troupe, load: Load) -> Decided:
    """Have all get ready for beat 0."""
    whole: Load = {**load, "when": "restart", "arming": {}}  # who has sought a beat after a stop must not play already
    if troupe.anyway:
        whole["anyway"] = True
    fresh = troupe.without_entry().with_all(troupe.alive, armed=False, misplaced={}, died_moving=False)
    troupe = replace(fresh, mode="gathering", joining=frozenset(), entering={})
    return troupe, [SendTo(host, troupe.load_for(host, whole)) for host in troupe.alive]


def _join(troupe: Troupe, host: str, now: Times) -> Decided:
    """Have a stage play along that doesn't yet: at once if the others play, otherwise as soon as they do."""
    if not troupe.is_on:
        return troupe, []
    led = troupe.lead == host
    troupe = troupe.without(host).with_member(host, armed=False)
    troupe = replace(troupe, joining=troupe.joining | {host})
    leads: list[Act] = [Say(troupe.position)] if led and troupe.position else []
    troupe, acts = _admit(troupe, now)
    return troupe, [*leads, *acts]


def _admit(troupe: Troupe, now: Times) -> Decided:
    """Have those play along who wait for it, if that is possible now."""
    if troupe.load is None or not troupe.joining:
        return troupe, []
    hosts, presses = sorted(troupe.joining), {host: member.pressed["count"] for host, member in troupe.members.items()}
    load: Load = {**troupe.load, "when": "restart"}
    if troupe.mode in ("gathering", "armed"):
        load["arming"] = {}
        troupe = replace(troupe, mode="gathering")
    elif troupe.mode == "playing" and now.at >= troupe.settles and (entry := troupe.entry_at(instant(troupe, now))):
        load["entry"] = entry
        troupe = replace(troupe, entering={**troupe.entering, **dict.fromkeys(hosts, troupe.generation)})
    else:
        return troupe, []
    troupe = replace(troupe, joining=frozenset())
    # It was asked for before, and nobody has stopped it: so each may know of all presses that it has heard.
    return troupe, [SendTo(host, {**troupe.load_for(host, load), "stops": presses[host]}) for host in hosts]


def _standing(load: Load) -> Load:
    """A score whose robots only have to stop."""
    parts = {robot: {**part, "scenes": [], "reset": None} for robot, part in load["score"]["parts"].items()}
    score = {**load["score"], "movements": [], "parts": parts}  # nothing can build on it: what comes next is sent whole
    standing: Load = {
        "type": "load",
        "generation": load["generation"],
        "score": score,
        "when": "restart",
        "backend": load["backend"],
    }
    return standing


def _resume(troupe: Troupe, resume: Resume | Anyway, now: Times) -> Decided:
    anyway, position = resume["type"] == "anyway", troupe.position
    if resume["type"] == "resume" and not troupe.may_start(resume.get("by")):
        return troupe, [warning(STOPPED)]
    if troupe.mode == "gathering":
        return troupe, [warning(NOT_READY)]
    if troupe.mode in ("armed", "paused") and troupe.clock and troupe.clock.stands:
        return replace(troupe, stands=True), []  # it is waited for
    if troupe.mode == "armed":
        return clock.enter(troupe, 0.0, now) if troupe.is_led else begin(troupe, now.at + troupe.ahead)
    if troupe.mode == "unplaced":
        return _gather(replace(troupe, anyway=anyway), troupe.load) if troupe.load else (troupe, [])
    if troupe.mode == "stopped" and position and position["state"] == "paused":
        # Somebody has sought since the stop: they go on from there, and who could not seek joins them.
        apart = {host for host in troupe.alive if not (said := troupe.members[host].transport) or said.get("deserted")}
        troupe = replace(troupe, mode="paused", joining=frozenset(apart))
    if position is None or troupe.mode != "paused":
        return troupe, []
    if troupe.is_led and not anyway:
        return clock.enter(troupe, position["beat"], now)
    # Who leads may have yet to say that it has paused.
    return go(troupe, troupe.alive, beat_at(position, now.at), now.at + troupe.ahead, resume)


def _armed(troupe: Troupe, host: str, said: Armed, now: Times) -> Decided:
    """A stage is ready for beat 0, or no longer. Once all have been told to begin, the one that leads says when it
    counts, and that it has begun."""
    ready = all(troupe.members[host].armed for host in troupe.alive)
    if troupe.mode == "gathering" and ready:
        if troupe.arming is None:
            return clock.ready(troupe, now) if troupe.clock else begin(troupe, now.at + troupe.ahead)
        begins = troupe.begins if troupe.begins < math.inf else None
        armed: Armed = {"type": "armed", "generation": troupe.generation, "armed": True, "begins": begins}
        if begins and troupe.count:
            armed["count"] = troupe.count
        return replace(troupe, mode="armed"), [Say(armed)]
    if troupe.mode == "armed" and not ready:
        not_armed: Armed = {"type": "armed", "generation": troupe.generation, "armed": False, "begins": None}
        return replace(troupe.without_entry(), mode="gathering"), [Say(not_armed)]
    if troupe.mode not in ("gathering", "armed") and host == troupe.lead:
        return troupe, [Say(said)]
    return troupe, []


def _transport(troupe: Troupe, host: str, transport: TransportMessage, now: Times) -> Decided:
    state, before = transport["state"], troupe.members[host].transport
    if troupe.members[host].died_moving:  # it only stops robots, whatever it says of that
        if state not in ("stopped", "ended"):
            return troupe, []
        return _obeyed(troupe.with_member(host, died_moving=False), host, troupe.unobeyed)
    moves = state in ("playing", "waiting")
    troupe = troupe.with_member(host, transport=transport, may_move=troupe.members[host].may_move and moves)
    if transport["generation"] >= troupe.entering.get(host, math.inf) and not transport.get("deserted"):
        troupe = replace(troupe, entering={each: sent for each, sent in troupe.entering.items() if each != host})
    by_lead: list[Act] = [Say(transport)] if host == troupe.lead else []
    if by_lead and state == "playing" and troupe.mode == "playing":
        troupe, acts = _admit(troupe, now)
        by_lead += acts
    if moves and not troupe.is_on and before is not None and before["state"] in ("stopped", "paused"):
        stray: Stop = {"type": "stop"}
        return troupe.with_member(host, may_move=True), [*by_lead, SendTo(host, stray)]  # all were to be stopped
    # Before all begin, what is said of an earlier score is old. While they play, whoever stops may have yet to take
    # over what was saved a moment ago.
    is_old = transport["generation"] != troupe.generation
    if host not in troupe.playing or (is_old and not (state == "stopped" and troupe.mode in ("playing", "paused"))):
        return troupe, by_lead
    if transport.get("too_near"):
        troupe = troupe.without_entry()  # a person has to make room, whatever a clock does
    if state == "stopped" and troupe.is_on:  # it has its reasons: an emergency stop, or it couldn't keep up
        others = troupe.others(host)
        troupe = replace(troupe.stopped().with_all(others, may_move=True), unconfirmed_at=now.at + CONFIRM_LIMIT)
        return troupe, [*(SendTo(each, stop_of(transport)) for each in others), Say(transport)]
    if state == "paused" and troupe.mode in ("gathering", "armed"):
        return replace(troupe, mode="unplaced"), [Say(transport)]
    was_paused = before is not None and before["state"] == "paused"
    is_old = (was_paused or transport["monotonic"] < troupe.since + CLOSE) and not transport.get("waits_for")
    if state == "paused" and troupe.mode == "playing" and is_old:
        # It has sought the beat from which all go on, or is late to say that it was paused. Of two robots that come too
        # near to each other, each is paused by its own stage, and the second may say so after a person resumes.
        return troupe, []
    if state == "paused" and troupe.mode == "playing":
        others = troupe.others(host)
        pause: Pause = {"type": "pause"}
        troupe = replace(troupe, mode="paused", paused_by=frozenset({host}), paused_first=host)
        return troupe, [*(SendTo(each, pause) for each in others), Say(transport)]
    if state == "paused" and troupe.mode == "paused" and _waits(transport):
        return replace(troupe, paused_by=troupe.paused_by | {host}), [Say(transport)]
    if state == "playing" and troupe.mode == "paused" and host in troupe.paused_by:
        return _goes_on(troupe, host, transport, now)
    if state == "ended" and host == troupe.lead:
        by_lead += _keep_out(troupe)
        troupe = troupe.stopped()
    troupe, joins = _in_one_scene(troupe, host, now)
    return troupe, [*by_lead, *joins]


def _in_one_scene(troupe: Troupe, host: str, now: Times) -> Decided:
    """Have stages join the leading one if they began a scene at another beat: some news of its end came late."""
    acts: list[Act] = []
    for each in troupe.others(host) if host == troupe.lead else [host]:
        if troupe.mode == "playing" and each in troupe.playing and troupe.is_apart(each):
            troupe, more = _join(troupe.with_member(each, transport=None), each, now)
            acts += more
    return troupe, acts


def _goes_on(troupe: Troupe, host: str, transport: TransportMessage, now: Times) -> Decided:
    """A stage that had paused by itself goes on by itself: so do the others, unless another one still waits."""
    others = troupe.others(host)
    left = troupe.paused_by - {host}
    if left:
        pause: Pause = {"type": "pause"}
        return replace(troupe, paused_by=left), [SendTo(host, pause)]
    at = now.at + troupe.ahead
    troupe, acts = go(troupe, others, beat_at(transport, at), at)
    return troupe, [*acts, Say(transport)]


def _gone(troupe: Troupe, host: str, why: str) -> Decided:
    led, member = troupe.lead == host, troupe.members[host]
    before = member.transport
    reported = before is not None and before["state"] in ("playing", "waiting")
    moved = reported or member.may_move or member.died_moving
    troupe = troupe.with_member(host, alive=False, armed=False, may_move=False, died_moving=moved)
    troupe = troupe.without(host)
    if not troupe.alive:
        return replace(troupe, mode="stopped"), [Say({"type": "gone", "message": why})]
    goes_on = troupe.is_on and troupe.lead is not None
    line = f"{host or 'the stage here'}: {why}"
    acts: list[Act] = [
        warning(f"{line}; the others go on, and it joins them again" if goes_on else line),
        StartHost(host),
    ]
    if goes_on and led and (position := troupe.position):
        acts.append(Say(position))
    if troupe.is_on and not goes_on:
        acts += _keep_out(troupe)
        troupe = troupe.stopped()
        acts += [Say({**before, "state": "stopped"})] if before else []
    return troupe, acts


def _keep_out(troupe: Troupe) -> list[Act]:
    """Stop those that were sent what the others played: it is over."""
    stop: Stop = {"type": "stop"}
    return [SendTo(host, stop) for host in sorted(troupe.entering)]


def _obeyed(troupe: Troupe, host: str, marks: Iterable[str]) -> Decided:
    """The stage of a host has obeyed these stops; say who has yet to."""
    acts: list[Act] = []
    for mark in [*marks]:
        if host in troupe.unobeyed.get(mark, ()):
            left = troupe.unobeyed[mark] - {host}
            rest = {other: hosts for other, hosts in troupe.unobeyed.items() if other != mark}
            troupe = replace(troupe, unobeyed={**rest, mark: left} if left else rest)
            waits = [each or "the stage here" for each in sorted(left)]
            acts.append(Say({"type": "obeyed", "mark": mark, "waits_for": waits}))
    return troupe, acts


def _pressed(troupe: Troupe) -> Decided:
    """Say which emergency stops are on, wherever they were heard."""
    counts = {host: member.pressed["count"] for host, member in troupe.members.items()}
    topics = sorted({topic for member in troupe.members.values() for topic in member.pressed["topics"]})
    kept = dict([*troupe.presses.items(), (sum(counts.values()), counts)][-MOST_PRESSES:])
    pressed: Pressed = {"type": "pressed", "topics": topics, "count": sum(counts.values())}
    return replace(troupe, presses=kept), [Say(pressed)]


def _presses_of(troupe: Troupe, host: str, pressed: Pressed) -> Pressed:
    return {**pressed, "count": troupe.presses.get(pressed["count"], {}).get(host, pressed["count"])}


def _about_robots(troupe: Troupe, host: str, message: FromStage) -> list[Act]:
    """What a stage says about its robots. What they sense decides for all when scenes begin."""
    if message["type"] == "measured":
        ours = {robot: each for robot, each in message["robots"].items() if troupe.owns(host, robot)}
        return [Say({**message, "robots": ours})] if ours else []
    robot = message.get("robot")
    if isinstance(robot, str) and not troupe.owns(host, robot):
        return []
    acts: list[Act] = [Say(message)]
    if message["type"] == "sensed":
        acts += [SendTo(other, message) for other in troupe.others(host)]
    return acts


def _where_it_is(troupe: Troupe, now: Times) -> list[Act]:
    """Tell the others where the one that leads is."""
    position = troupe.position
    if position is None or position["state"] != "playing":
        return []
    beat, pace = beat_at(position, now.at), position.get("pace", 1.0)
    bend: BendMessage = {"type": "bend", "at": now.at, "beat": beat, "pace": pace}
    return [SendTo(host, bend) for host in troupe.alive if host != troupe.lead and host not in troupe.joining]


def _waits(transport: TransportMessage) -> bool:
    return bool(transport.get("waits_for") or transport.get("too_near"))


def _all(troupe: Troupe, message: ToStage) -> list[Act]:
    return [SendTo(host, message) for host in troupe.alive]
