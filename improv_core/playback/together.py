"""How stages on several machines play as one: `(group, event, now) -> (group, acts)`. Nothing here does anything.

Each has the whole score and moves the robots of its host. What they are to do at an instant is sent ahead of it, by as
long as the slowest message may take. Standard library only.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

from improv_core.playback.group import HERE, Group, beat_at
from improv_core.playback.stage_process import Heard
from improv_core.stage.commands import COMMANDS, Pause, Stop
from improv_core.stage.messages import FromStage, Load, Pressed, ToStage, TransportMessage

CONFIRM_LIMIT = 1.0
"""Seconds that a stop may take to be confirmed. Then people are told which robots may still be moving."""
EDGE = 0.01
"""Seconds: no time is chosen so shortly before or after a beat, since two stages might take it for another beat."""
BEGIN_EARLY = 1.0
"""Seconds before the time at which a dance begins by itself, from which on it is told to all."""
MOST_PRESSES = 20
"""Counts of presses that are remembered. A score that somebody asked for longer ago is refused by hosts."""
NOT_READY = "not begun: robots are still waited for; begin once it says `armed`"


@dataclass(frozen=True, slots=True)
class Now:
    """The monotonic time, and Unix time."""

    at: float
    wall: float = 0.0


@dataclass(frozen=True, slots=True)
class Tell:
    """Send a message to the stage of a host."""

    host: str
    message: ToStage


@dataclass(frozen=True, slots=True)
class Say:
    """Say a message to whoever believes that all are one stage."""

    message: Heard


@dataclass(frozen=True, slots=True)
class StartAgain:
    """Start the stage of a host again."""

    host: str


Act = Tell | Say | StartAgain
Decided = tuple[Group, list[Act]]


def told(group: Group, message: ToStage, now: Now) -> Decided:
    """What follows from what all are told. Stops and pauses have been sent already: see `in_time`."""
    kind = message["type"]
    if message["type"] == "load":
        return _load(group, message, now)
    if message["type"] == "stop":
        group = group.with_all(group.alive, may_move=group.is_on, armed=False)
        group = replace(group, mode="stopped", joining=frozenset(), paused_by=frozenset())
        return replace(group, unconfirmed_at=now.at + CONFIRM_LIMIT), []
    if message["type"] == "pause":
        if group.mode == "playing":
            group = replace(group, mode="paused", paused_by=frozenset())
        elif group.mode != "paused":
            group = replace(group, mode="stopped", joining=frozenset())
        return group, []
    if message["type"] == "resume" or message["type"] == "anyway":
        return _resume(group, message["type"] == "anyway", now)
    if message["type"] == "pressed":
        return group, [Tell(host, _presses_of(group, host, message)) for host in group.alive]
    if kind not in COMMANDS:
        return group, [Tell(HERE, message)] if HERE in group.alive else []  # for pages
    if COMMANDS[kind].kept:
        group = replace(group, kept={**group.kept, kind: message})
    return group, _all(group, in_time(group, message, now))


def in_time(group: Group, message: Any, now: Now) -> Any:
    """What is asked of all, for an instant at which all have heard it. A stop is for now."""
    if message["type"] == "stop" or group.mode != "playing":
        return message
    return {**message, "at": _instant(group, now)}


def started(group: Group, host: str, now: Now) -> Decided:
    """A stage has started, or started again."""
    fresh = replace(group.members[host], alive=True, armed=False, state="stopped", transport=None, may_move=False)
    group = replace(group, members={**group.members, host: replace(fresh, misplaced={})})
    kept: list[Act] = [Tell(host, message) for message in group.kept.values()]
    group, acts = _join(group, host, now)
    return group, [*kept, *acts]


def said(group: Group, host: str, message: Heard, now: Now) -> Decided:
    """What follows from what a stage says."""
    if host not in group.alive:
        return group, []
    if message["type"] == "transport":
        return _transport(group, host, message, now)
    if message["type"] == "armed":
        return _armed(group.with_member(host, armed=message["armed"]), now)
    if message["type"] == "lacks":
        return _join(group, host, now)
    if message["type"] == "deserted":
        line = f"{host} heard nothing from here for {message['seconds']:g} s, so its robots stopped"
        if group.is_on and any(each != host and each not in group.joining for each in group.alive):
            group, acts = _join(group, host, now)
            return group, [_warning(f"{line}; they join the others again"), *acts]
        return group, [_warning(f"{line}: play again")]
    if message["type"] == "gone":
        return _gone(group, host, message["message"])
    if message["type"] == "misplaced":
        group = group.with_member(host, misplaced=message["robots"])
        robots = {robot: each for member in group.members.values() for robot, each in member.misplaced.items()}
        return group, [Say({**message, "robots": robots})]
    if message["type"] == "pressed":
        return _pressed(group.with_member(host, pressed=message))
    if message["type"] == "link":
        return group.with_member(host, lag=message["lag"]), [Say(message)]
    if message["type"] == "warning" or message["type"] == "error":
        line = f"{host}: {message['message']}" if host else message["message"]
        return group, [Say(cast(FromStage, {**message, "message": line}))]
    if message["type"] == "stopped":
        return group, []
    return group, _about_robots(group, host, message)


def waited(group: Group, now: Now) -> Decided:
    """What follows once a time has come that `due` named."""
    acts: list[Act] = []
    if now.at >= group.unconfirmed_at:
        group = replace(group, unconfirmed_at=math.inf)
        hosts = [host for host in group.members if group.members[host].may_move]
        if robots := [robot for host in hosts for robot in group.of(host)]:
            line = f"{', '.join(robots)} may still be moving: {', '.join(hosts)} has not confirmed the stop"
            acts.append(Say({"type": "unreached", "generation": group.generation, "robots": robots, "message": line}))
    if group.mode == "armed" and now.wall >= group.begins - BEGIN_EARLY:
        group, more = _begin(group, now.at + max(group.begins - now.wall, group.ahead))
        acts += more
    return group, acts


def due(group: Group, now: Now) -> float:
    """When `waited` is to be called, in monotonic seconds; infinite if nothing is waited for."""
    begins = now.at + group.begins - BEGIN_EARLY - now.wall if group.mode == "armed" else math.inf
    return min(group.unconfirmed_at, begins)


def _load(group: Group, load: Load, now: Now) -> Decided:
    goes_on = load["when"] != "restart" and group.mode in ("playing", "paused")
    group = group.loading(load)
    lost = group.of(HERE) if HERE not in group.alive else []
    line = f"nobody moves {', '.join(lost)}: no ROS 2 runs here, and they have no `host`"
    unmoved: list[Act] = [_warning(line)] if lost else []
    if goes_on:
        at: Load = {**load, "at": _instant(group, now)} if group.mode == "playing" else load
        sent = [Tell(host, group.load_for(host, at)) for host in group.alive if host not in group.joining]
        return group, [*unmoved, *sent]
    arming = load.get("arming")
    begins = arming.get("begins", math.inf) if arming is not None else math.inf
    group = replace(group, arming=arming, begins=begins, anyway=load.get("anyway", False), paused_by=frozenset())
    group, acts = _gather(group, load)
    return group, [*unmoved, *acts]


def _gather(group: Group, load: Load) -> Decided:
    """Have all get ready for beat 0."""
    whole: Load = {**load, "arming": {}}
    if group.anyway:
        whole["anyway"] = True
    group = replace(group.with_all(group.alive, armed=False, misplaced={}), mode="gathering", joining=frozenset())
    return group, [Tell(host, group.load_for(host, whole)) for host in group.alive]


def _join(group: Group, host: str, now: Now) -> Decided:
    """Have a stage play along that doesn't yet: at once if the others play, otherwise as soon as they do."""
    if not group.is_on:
        return group, []
    return _admit(replace(group, joining=group.joining | {host}).with_member(host, armed=False), now)


def _admit(group: Group, now: Now) -> Decided:
    """Have those play along who wait for it, if that is possible now."""
    if group.load is None or not group.joining:
        return group, []
    hosts, presses = sorted(group.joining), {host: member.pressed["count"] for host, member in group.members.items()}
    load: Load = {**group.load, "when": "restart"}
    if group.mode in ("gathering", "armed"):
        load["arming"] = {}
        group = replace(group, mode="gathering")
    elif group.mode == "playing" and (entry := group.entry_at(_instant(group, now))):
        load["entry"] = entry
    else:
        return group, []
    group = replace(group, joining=frozenset())
    sent = {host: group.load_for(host, load) for host in hosts}
    for host in hosts:
        sent[host]["stops"] = presses[host]  # it was asked for before, and nobody has stopped it
    return group, [Tell(host, sent[host]) for host in hosts]


def _resume(group: Group, anyway: bool, now: Now) -> Decided:
    if group.mode == "gathering":
        return group, [_warning(NOT_READY)]
    if group.mode == "armed":
        return _begin(group, now.at + group.ahead)
    if group.mode == "unplaced":
        return _gather(replace(group, anyway=anyway), group.load) if group.load else (group, [])
    if group.mode != "paused":
        return group, []
    if (position := group.position) is None:
        return group, []
    return _go(group, group.alive, position["beat"], now.at + group.ahead, anyway=anyway)


def _go(group: Group, hosts: Iterable[str], beat: float, at: float, *, anyway: bool = False) -> Decided:
    """Have stages that are paused go on from one beat, all at the same time."""
    group = replace(group, mode="playing", paused_by=frozenset())
    resume: ToStage = {"type": "anyway", "at": at} if anyway else {"type": "resume", "at": at}
    acts: list[Act] = []
    for host in hosts:
        if host in group.joining:
            continue
        transport = group.members[host].transport
        if transport and transport["beat"] != beat:
            acts.append(Tell(host, {"type": "seek", "beat": beat, "at": at}))
        acts.append(Tell(host, resume))
    return group, acts


def _begin(group: Group, at: float) -> Decided:
    """Beat 0 is at this time, for all."""
    group = replace(group, mode="playing", begins=math.inf)
    return group, [Tell(host, {"type": "resume", "at": at}) for host in group.alive]


def _armed(group: Group, now: Now) -> Decided:
    ready = all(group.members[host].armed for host in group.alive)
    if group.mode == "gathering" and ready:
        if group.arming is None:
            return _begin(group, now.at + group.ahead)
        begins = group.begins if group.begins < math.inf else None
        armed: FromStage = {"type": "armed", "generation": group.generation, "armed": True, "begins": begins}
        return replace(group, mode="armed"), [Say(armed)]
    if group.mode == "armed" and not ready:
        not_armed: FromStage = {"type": "armed", "generation": group.generation, "armed": False, "begins": None}
        return replace(group, mode="gathering"), [Say(not_armed)]
    return group, []


def _transport(group: Group, host: str, transport: TransportMessage, now: Now) -> Decided:
    state, was_moving = transport["state"], group.members[host].may_move
    group = group.with_member(
        host, state=state, transport=transport, may_move=was_moving and state in ("playing", "waiting")
    )
    by_lead: list[Act] = [Say(transport)] if host == group.lead else []
    if by_lead and state == "playing" and group.mode == "playing":
        group, acts = _admit(group, now)
        by_lead += acts
    if transport["generation"] != group.generation or host in group.joining:
        return group, by_lead
    if state == "stopped" and group.is_on:  # it has its reasons: an emergency stop, or it couldn't keep up
        others = [each for each in group.alive if each != host]
        group = replace(group, mode="stopped", joining=frozenset(), paused_by=frozenset())
        group = replace(group.with_all(others, may_move=True), unconfirmed_at=now.at + CONFIRM_LIMIT)
        stop: Stop = {"type": "stop"}
        return group, [*(Tell(each, stop) for each in others), Say(transport)]
    if state == "paused" and group.mode in ("gathering", "armed"):
        return replace(group, mode="unplaced"), [Say(transport)]
    if state == "paused" and group.mode == "playing":
        others = [each for each in group.alive if each != host]
        pause: Pause = {"type": "pause"}
        group = replace(group, mode="paused", paused_by=frozenset({host}))
        return group, [*(Tell(each, pause) for each in others), Say(transport)]
    if state == "paused" and group.mode == "paused" and _waits(transport):
        return replace(group, paused_by=group.paused_by | {host}), [Say(transport)]
    if state == "playing" and group.mode == "paused" and host in group.paused_by:
        return _goes_on(group, host, transport, now)
    if state == "ended" and host == group.lead:
        group = replace(group, mode="stopped", joining=frozenset())
    return group, by_lead


def _goes_on(group: Group, host: str, transport: TransportMessage, now: Now) -> Decided:
    """A stage that had paused by itself goes on by itself: so do the others, unless another one still waits."""
    others = [each for each in group.alive if each != host]
    left = group.paused_by - {host}
    if left:
        pause: Pause = {"type": "pause"}
        return replace(group, paused_by=left), [Tell(host, pause)]
    at = now.at + group.ahead
    group, acts = _go(group, others, beat_at(transport, at), at)
    return group, [*acts, Say(transport)]


def _gone(group: Group, host: str, why: str) -> Decided:
    led, before = group.lead == host, group.members[host].transport
    group = group.with_member(host, alive=False, armed=False, may_move=False)
    group = replace(group, joining=group.joining - {host}, paused_by=group.paused_by - {host})
    if not group.alive:
        return replace(group, mode="stopped"), [Say({"type": "gone", "message": why})]
    goes_on = group.is_on and group.lead is not None
    line = f"{host or 'the stage here'}: {why}"
    acts: list[Act] = [
        _warning(f"{line}; the others go on, and it joins them again" if goes_on else line),
        StartAgain(host),
    ]
    if goes_on and led and (position := group.position):
        acts.append(Say(position))
    if group.is_on and not goes_on:
        group = replace(group, mode="stopped", joining=frozenset())
        acts += [Say({**before, "state": "stopped"})] if before else []
    return group, acts


def _pressed(group: Group) -> Decided:
    """Tell of all emergency stops that any stage has heard."""
    counts = {host: member.pressed["count"] for host, member in group.members.items()}
    topics = sorted({topic for member in group.members.values() for topic in member.pressed["topics"]})
    kept = dict([*group.presses.items(), (sum(counts.values()), counts)][-MOST_PRESSES:])
    pressed: Pressed = {"type": "pressed", "topics": topics, "count": sum(counts.values())}
    return replace(group, presses=kept), [Say(pressed)]


def _presses_of(group: Group, host: str, pressed: Pressed) -> Pressed:
    return {**pressed, "count": group.presses.get(pressed["count"], {}).get(host, pressed["count"])}


def _about_robots(group: Group, host: str, message: FromStage) -> list[Act]:
    """What a stage says about its robots. What they sense decides for all when scenes begin."""
    if message["type"] == "vitals" or message["type"] == "measured":
        robots: Mapping[str, Any] = message["robots"]
        ours = {robot: each for robot, each in robots.items() if group.owns(host, robot)}
        return [Say(cast(FromStage, {**message, "robots": ours}))] if ours else []
    robot = message.get("robot")
    if isinstance(robot, str) and not group.owns(host, robot):
        return []
    acts: list[Act] = [Say(message)]
    if message["type"] == "sensed":
        acts += [Tell(other, message) for other in group.alive if other != host]
    return acts


def _instant(group: Group, now: Now) -> float:
    """A time at which all have heard what is sent to them now, and that isn't too close to a beat."""
    at, position = now.at + group.ahead, group.position
    if position is None or position["state"] != "playing":
        return at
    beat, edge = beat_at(position, at), EDGE * position["tempo"] / 60
    return at + 2 * EDGE if abs(beat - round(beat)) < edge else at


def _waits(transport: TransportMessage) -> bool:
    return bool(transport.get("waits_for") or transport.get("too_near"))


def _all(group: Group, message: ToStage) -> list[Act]:
    return [Tell(host, message) for host in group.alive]


def _warning(line: str) -> Act:
    return Say({"type": "warning", "message": line})
