"""Decides for the stages of real robots on several machines, which play as one: `(state, event, now) -> (state, acts)`,
without side effects. Standard library only.

Each stage has the whole score and moves the robots of its host. A command for an instant is sent ahead of it, by as
long as the slowest message may take. Each announcement is a report of all: `on_report` takes it like the report of a
single stage.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from improv_core.protocol.clock_messages import BendMessage
from improv_core.protocol.commands import Resume
from improv_core.protocol.messages import Pressed
from improv_core.protocol.play_again import NOT_READY, STOPPED
from improv_core.score.takeover import Takeover
from improv_core.session import clock, together
from improv_core.session.acts import Act, Announce, Now, SendScore, StateAndActs, send, warning
from improv_core.session.halting import halt
from improv_core.session.state import HERE, PlayScore, SessionState, StageKey
from improv_core.session.together import DRIFT_PERIOD, EARLY, begin, instant, playing_from, resume_at, settling

CONFIRM_LIMIT = 1.0
"""Seconds within which stages confirm a stop. Then a line names the robots that may still be moving."""
SEEN_PERIOD = 0.02
"""The fewest seconds between two messages to a stage about the poses of other stages' robots. Each stage reports those
up to twenty times a second, and a dozen of them would get a thousand messages a second."""


def in_time(state: SessionState, message: Any, now: Now) -> Any:
    """Return a request with an instant by which all have received it. A stop takes effect at once."""
    if message["type"] == "stop" or state.mode != "playing":
        return message
    return {**message, "at": instant(state, now)}


def play(state: SessionState, wanted: PlayScore, now: Now) -> list[Act]:
    """Send all a score that somebody asked for. Once it has been sent, `plays` follows."""
    if not together.may_start(state, wanted.by):
        return [warning(STOPPED)]
    wants = replace(state, on_robots=wanted)
    lost = together.robots_of(wants, HERE) if HERE not in state.alive else []
    line = f"nobody moves {', '.join(lost)}: no ROS 2 runs here, and they have no `host`"
    return [*clock.follow(wants)[1], *([warning(line)] if lost else []), _score(state, wanted, now)]


def plays(state: SessionState, wanted: PlayScore, now: Now) -> SessionState:
    """Return the state in which all have been sent a score that somebody asked for."""
    state, _ = clock.follow(replace(state, on_robots=wanted))
    if not _continues(state, wanted):
        return _gathering(state)
    if state.mode == "paused":  # each continues as soon as it has this, so they soon need the lead's position
        state = replace(playing_from(state, now.at), drifts=now.at)
    return settling(state, now)


def resume(state: SessionState, message: Resume, now: Now) -> StateAndActs:
    """Have all begin or continue."""
    anyway, lead = message.get("anyway", False), together.position(state)
    if not together.may_start(state, message.get("by")):
        return state, [warning(STOPPED)]
    if state.mode == "gathering":
        return state, [warning(NOT_READY)]
    if state.mode in ("armed", "paused") and state.following and state.following.stands:
        return replace(state, stands=True), []  # the clock has to continue first
    if state.mode == "armed":
        at = now.at + together.ahead(state)
        return clock.enter(state, 0.0, now) if together.is_led(state) else begin(state, at)
    if state.mode == "unplaced":
        again = replace(state.on_robots, anyway=anyway, stops=now.stops, by=None)
        return _gathering(replace(state, on_robots=again)), [_score(state, again, now)]
    if state.mode == "stopped" and lead and (lead["state"] == "paused" or "beat" in message):
        # Somebody has sought since the stop, or does: they continue from there, and stages that can't seek join them.
        said = {host: state.robots[host].transport for host in state.alive}
        apart = {host for host, each in said.items() if not each or each.get("deserted")}
        state = together.with_all(state, apart, died_moving=False, only_halts=False)  # they get a score that moves
        state = replace(state, mode="paused", joining=frozenset(apart), stood=None)
    if lead is None or state.mode != "paused":
        return state, []
    # The lead may have yet to report that it has paused.
    beat = message.get("beat", together.beat_at(lead, now.at))
    if together.is_led(state) and not anyway:
        return clock.enter(state, beat, now)
    return resume_at(state, state.alive, beat, now.at + together.ahead(state), message)


def change(state: SessionState, message: Any, now: Now) -> StateAndActs:
    """Have all obey a request that starts nothing, at one instant."""
    acts: list[Act] = [send(host, in_time(state, message, now)) for host in state.alive]
    if message["type"] == "seek" and state.enters < math.inf:
        state, entering = clock.enter(state, message["beat"], now)
        return state, [*acts, *entering]
    return settling(state, now), acts


def stop(state: SessionState, now: Now) -> StateAndActs:
    """Note a stop that all have been sent."""
    if state.mode != "stopped":  # after a second stop, a stage that has yet to confirm the first one may still move
        state = together.with_all(state, state.alive, may_move=True)
    # New stages that have yet to play along: their robots may still move as the stages before left them.
    new = [host for host in {*state.joining, *state.entering} if not state.robots[host].transport]
    halts = [halt(state, StageKey(host, "ros")) for host in sorted(new)]
    state = together.stopped(together.with_all(state, state.alive, armed=False))
    limit = now.at + CONFIRM_LIMIT if state.is_spread else math.inf
    return replace(state, unconfirmed_at=min(state.unconfirmed_at, limit)), [*halts]


def pause(state: SessionState) -> SessionState:
    """Note a pause that all have been sent."""
    state = together.without_entry(state)
    if state.mode == "playing":
        return replace(state, mode="paused", paused_by=frozenset())
    return state if state.mode == "paused" else together.stopped(state)


def pressed_of(state: SessionState, host: str, pressed: Pressed) -> Pressed:
    """Return the emergency stops that are on as the stage of a host counts them."""
    return {**pressed, "count": state.presses.get(pressed["count"], {}).get(host, pressed["count"])}


def waited(state: SessionState, now: Now) -> StateAndActs:
    """Do what is due at a time that `due` named."""
    acts: list[Act] = []
    if now.at >= state.unconfirmed_at:
        state, acts = unconfirmed(state)
    if now.at >= state.drifts:
        state = replace(state, drifts=now.at + DRIFT_PERIOD)
        acts += _share_position(state, now)
    opens = together.opens(state)
    if state.mode == "armed" and now.wall >= opens - EARLY:
        state, more = begin(state, now.at + max(opens - now.wall, together.ahead(state)))
        acts += more
    state, entered = clock.waited(state, now)
    state, admitted = admit(state, now)
    state, passed = pass_on_seen(state, now)
    return state, [*acts, *entered, *admitted, *passed]


def unconfirmed(state: SessionState) -> StateAndActs:
    """Name the robots that may still move after a stop, if people wait for its confirmation."""
    if state.unconfirmed_at == math.inf:
        return state, []
    state = replace(state, unconfirmed_at=math.inf)
    hosts = [host for host, stage in state.robots.items() if stage.may_move]
    robots = [robot for host in hosts for robot in together.robots_of(state, host)]
    if not robots:
        return state, []
    named = ", ".join(host or "the stage here" for host in hosts)
    line = f"{', '.join(robots)} may still be moving: {named} has not confirmed the stop"
    return state, [Announce({"type": "unreached", "generation": state.generation, "robots": robots, "message": line})]


def due(state: SessionState, now: Now) -> float:
    """Return the time of the next call of `waited`, in monotonic seconds; infinite if there is none."""
    begins = now.at + together.opens(state) - EARLY - now.wall if state.mode == "armed" else math.inf
    drifts = state.drifts if state.mode == "playing" else math.inf
    settles = state.settles if state.joining and state.settles > now.at else math.inf
    passes_on = state.passes_on if state.seen else math.inf
    return min(state.unconfirmed_at, begins, drifts, settles, clock.due(state), passes_on)


def join(state: SessionState, host: str, now: Now) -> StateAndActs:
    """Have a stage that doesn't play yet join: at once if the others play, otherwise as soon as they do."""
    if state.mode == "stopped":
        return state, []
    led = together.lead(state) == host
    state = together.with_all(together.without(state, host), [host], armed=False)
    state = replace(state, joining=state.joining | {host})
    lead = together.position(state)
    state, acts = admit(state, now)
    return state, [*([Announce(lead)] if led and lead else []), *acts]


def _continues(state: SessionState, wanted: PlayScore) -> bool:
    """Return whether a score takes over from another one. Otherwise, all get ready for beat 0."""
    return wanted.when != "restart" and state.mode in ("playing", "paused")


def _score(state: SessionState, wanted: PlayScore, now: Now) -> SendScore:
    joins, at = frozenset[str](), None
    if continues := _continues(state, wanted):
        joins = playing_from(state, now.at).joining if state.mode == "paused" else state.joining
        at = instant(state, now) if state.mode == "playing" else None
    to = [StageKey(host, "ros") for host in state.alive if host not in joins]
    return SendScore(to, wanted, at=at, stops=_known_presses(state, now), asked=True, gathers=not continues)


def _gathering(state: SessionState) -> SessionState:
    """Return the state in which all get ready for beat 0."""
    fresh = {"armed": False, "misplaced": {}, "died_moving": False, "only_halts": False}
    state = together.with_all(together.without_entry(state), state.alive, **fresh)
    return replace(state, mode="gathering", joining=frozenset(), entering={}, paused_by=frozenset())


def admit(state: SessionState, now: Now) -> StateAndActs:
    """Have the stages that wait to join play along, if that is possible now."""
    hosts, entry = sorted(state.joining), None
    if not hosts:
        return state, []
    gathers = state.mode in ("gathering", "armed")
    if gathers:
        state = replace(state, mode="gathering")
    elif state.mode == "playing" and now.at >= state.settles and (entry := _entry(state, instant(state, now))):
        state = replace(state, entering={**state.entering, **dict.fromkeys(hosts, state.generation)})
    else:
        return state, []
    state = replace(state, joining=frozenset())
    # Somebody asked for the score earlier, and nobody has stopped it: so each may know of all presses it has received.
    stops = {StageKey(host, "ros"): state.robots[host].pressed["count"] for host in hosts}
    wanted = replace(state.on_robots, when="restart", by=None, arming=None)
    return state, [SendScore([*stops], wanted, entry, stops=stops, whole=True, gathers=gathers)]


def _known_presses(state: SessionState, now: Now) -> dict[StageKey, int]:
    """Return the presses of emergency stops that people know of, for each stage: the others count as none."""
    presses = state.presses.get(now.known, {})
    return {StageKey(host, "ros"): presses.get(host, 0) for host in state.alive}


def pass_on_seen(state: SessionState, now: Now) -> StateAndActs:
    """Send each stage the poses of all others' robots, which it has to keep its own apart from, if that is due."""
    if not state.seen or now.at < state.passes_on:
        return state, []
    acts: list[Act] = []
    for host in state.alive:
        robots = {robot: each for robot, each in state.seen.items() if together.host_of(state, robot) != host}
        acts += [send(host, {"type": "seen", "robots": robots})] if robots else []
    return replace(state, seen={}, passes_on=now.at + SEEN_PERIOD), acts


def _share_position(state: SessionState, now: Now) -> list[Act]:
    lead = together.position(state)
    if lead is None or lead["state"] != "playing":
        return []
    beat, pace = together.beat_at(lead, now.at), lead.get("pace", 1.0)
    bend: BendMessage = {"type": "bend", "at": now.at, "beat": beat, "pace": pace}
    hosts = [host for host in state.alive if host != together.lead(state) and host not in state.joining]
    return [send(host, bend) for host in hosts]


def _entry(state: SessionState, at: float) -> Takeover | None:
    """Return the position of the others at a time, for a stage that joins them; None if they don't play this score."""
    lead = together.position(state)
    if lead is None or lead["state"] != "playing" or lead["generation"] != state.generation:
        return None
    return together.entry_at(lead, together.beat_at(lead, at), at)
