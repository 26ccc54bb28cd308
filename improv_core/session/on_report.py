"""Decides about what stages report, their starts, and their ends: `(state, stage, message, now) -> (state, acts)`,
without side effects. Standard library only."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

from improv_core.ipc.stage_process import Gone, Heard
from improv_core.music.clock_process import HeardClock
from improv_core.protocol.clock_messages import BendMessage
from improv_core.protocol.commands import COMMANDS
from improv_core.protocol.messages import Decided, Obeyed, Ready, Sensed, ToStage, TransportMessage
from improv_core.protocol.page_messages import ForPages, for_pages
from improv_core.protocol.robot_messages import FaultMessage, Resumes, WhyStill
from improv_core.protocol.transport import stop_of
from improv_core.safety.stage_stops import stages_not_stopped
from improv_core.session import clock, host_reports, on_hosts
from improv_core.session.acts import (
    Act,
    Announce,
    HearClock,
    Now,
    Report,
    Send,
    SendScore,
    Start,
    StateAndActs,
    warning,
)
from improv_core.session.halting import halt, has_halted, stand, stood
from improv_core.session.on_request import on_request, send_score
from improv_core.session.state import HERE, Output, PlayScore, SessionState, StageKey, StageState
from improv_core.session.together import entry_at, others, stopped, without

BEHIND = 0.1
"""Seconds by which the simulator plays a score with senses behind real robots: their decisions have to arrive first."""


def on_report(state: SessionState, stage: StageKey, message: Report, now: Now) -> StateAndActs:
    """Return the state after a stage has sent a message, has started, or has ended, and the acts that follow."""
    match message["type"]:
        case "request":
            command = message["command"]
            # Stops and pauses were obeyed and noted when they arrived.
            return (state, []) if command["type"] in ("stop", "pause") else on_request(state, command, now)
        case "loaded":
            return _loaded(state, message["play"], now)
        case "ready":
            return _started(state, stage, message, now)
        case "failed":
            return _not_started(state, stage, message["message"])
        case "obeyed":
            return _obeyed(state.with_stage(stage, obeyed=message["direct"]), message)
        case "gone" if stage.output != "ros" or not others(state, stage.host):
            return _gone(state, stage, message, now)
        case _ if stage.output == "ros" and state.is_spread:
            return _as_one(host_reports.reported(state, stage.host, message, now))
        case "lacks":
            return _send_again(state, stage, message["generation"], now)
        case "armed":
            return _reported(state.with_stage(stage, armed=message["armed"]), stage.output, message)
        case "transport" if has_halted(state, stage, message):
            state, acts = _reported(state, stage.output, message)
            return state.with_stage(stage, died_moving=False), [*acts, *stand(state, stage, now)]
        case _:
            return _reported(state, stage.output, message)


def on_time(state: SessionState, now: Now) -> StateAndActs:
    """Return the state after the time for which stages on several machines waited, and the acts that follow."""
    return _as_one(on_hosts.waited(state, now))


def on_close(state: SessionState) -> StateAndActs:
    """Return the state before all stages end, and the acts that follow."""
    return _as_one(on_hosts.unconfirmed(state))


def on_clock(state: SessionState, message: HeardClock, now: Now) -> StateAndActs:
    """Return the state after news of a clock of music, which the leading stage follows, and the acts that follow."""
    match message["type"]:
        case "anchor" if state.is_real and state.is_spread:
            return clock.anchored(state, message, now) if state.following else (state, [])
        case "anchor":
            return state, _to(state.leader, message)
        case "warning":
            return state, [warning(message["message"])]
        case "error":
            return state, [Announce(message)]
        case "clock_gone":
            line = f"the clock is lost: {message['message']}" if message["message"] else ""
            said: list[Act] = [Announce({"type": "error", "message": line})] if line else []
            return replace(state, clock=None), [HearClock(None), *said]


def _as_one(decided: StateAndActs) -> StateAndActs:
    """Return what follows from what stages on several machines report as one."""
    state, acts = decided
    follows: list[Act] = []
    for act in acts:
        if isinstance(act, Announce):
            state, more = _reported(state, "ros", cast(Heard, act.news))
            follows += more
        else:
            follows.append(act)
    return state, follows


def _reported(state: SessionState, output: Output, message: Heard) -> StateAndActs:
    """Take a report that the listeners get, too."""
    leads, acts = state.leads(output), list[Act]()
    match message["type"]:
        case "transport":
            state, acts = _followed(state, output, message)
            acts += _show(state, message) if leads and not state.twin else []
        case "sensed" | "decided":
            if not leads:
                return state, []
            acts = _follow(state, message)
        case "fault" if leads:
            acts = _follow(state, message)
            if message["response"] == "stand" and not message["over"]:
                state = state.with_muted(message["robot"])
        case "measured" | "joints" | "vitals" | "link" | "armed" if leads:
            acts = _show(state, message)
        case "misplaced" if leads:
            # The twin waits, too: it may still play the previous score.
            pauses = _to(state.twin, {"type": "pause"}) if message["robots"] else []
            acts = [*pauses, *_show(state, message)]
        case "unreached" if leads:
            state, acts = _explained(state, message["message"], state.resumes)
    return state, [*acts, Announce(message, leads)]


def _obeyed(state: SessionState, message: Obeyed) -> StateAndActs:
    """Confirm a stop to pages once all stages have obeyed it that have to."""
    moves = {
        key.host or key.output: each
        for key, each in state.stages.items()
        if key.output != "page" and (each.alive or each.died_moving)
    }
    obeyed = [name for name, each in moves.items() if each.obeyed == message["direct"] and not each.died_moving]
    if stages_not_stopped(moves, obeyed):
        return state, []
    return state, [Send(page, for_pages(message)) for page in state.pages]


def _to(output: Output | None, message: ToStage) -> list[Act]:
    return [Send(StageKey(HERE, output), message)] if output else []


def _show(state: SessionState, message: ForPages) -> list[Act]:
    """Show a report of the leading stage on pages that don't get it from that stage itself."""
    return [Send(state.onlooker, for_pages(message))] if state.onlooker else []


def _follow(state: SessionState, message: Sensed | Decided | FaultMessage) -> list[Act]:
    """Have the twin do the same as real robots; it shows that, too."""
    return _to(state.twin, message) if state.twin else _show(state, message)


def _followed(state: SessionState, output: Output, transport: TransportMessage) -> StateAndActs:
    """Start the twin at exactly the same time as the leading stage, and stop and pause it when that one does."""
    if not state.leads(output):
        return state, []
    mode, waited, latest = transport["state"], state.waits_for, state.latest
    state, acts = _explained(state, _why_still(state, transport), transport.get("resumes"))
    offers_all = "resumes" in transport and all(each.alive and not each.died_moving for each in state.robots.values())
    state = replace(
        state.with_stage(StageKey(HERE, output), transport=transport) if not state.is_spread else state,
        stood=None if offers_all else state.stood,
        is_on=mode in ("waiting", "playing", "paused"),
        waits_for=transport.get("waits_for", transport.get("too_near", ())),
        editions=state.editions.plays(transport["generation"]),
    )
    if not state.twin:
        return state, acts
    if mode == "playing" and latest and not state.entered and transport["generation"] == latest.generation:
        state, enters = _enter(replace(state, entered=transport), latest, transport)
        return state, [*enters, *_bends(state, transport), *acts]
    if mode == "playing":
        resumes = _to(state.twin, {"type": "resume", "at": transport["monotonic"]}) if waited else []
        return state, [*resumes, *_bends(state, transport), *acts]
    if mode == "stopped":
        return state, [*_to(state.twin, stop_of(transport)), *acts]
    if mode == "paused" and state.waits_for:
        pauses = _to(state.twin, {"type": "pause", "at": transport["monotonic"]})
        if "pace" in transport and latest and not latest.score.open:  # perhaps back to where a clock stopped
            pauses += _to(state.twin, {"type": "seek", "beat": transport["beat"]})
        return state, [*pauses, *acts]
    return state, acts


def _bends(state: SessionState, transport: TransportMessage) -> list[Act]:
    """Have the twin play as fast as the leading stage, which follows a clock from outside."""
    if "pace" not in transport:
        return []
    at = transport["monotonic"] + state.behind
    bend: BendMessage = {"type": "bend", "at": at, "beat": transport["beat"], "pace": transport["pace"]}
    return [Send(StageKey(HERE, "simulator"), bend, state.behind)]


def _why_still(state: SessionState, transport: TransportMessage) -> str:
    """Return the reason why real robots stand, for pages. The reason for a stop stays until something else plays."""
    if near := transport.get("too_near"):
        return f"Too near to each other: {', '.join(near)}. Make room, then press Play."
    if transport["state"] == "paused" and (waits := transport.get("waits_for")):
        return f"Waiting for {', '.join(waits)}."
    if "resumes" in transport:
        return state.why_still or "Robots were stopped, although nobody asked for that."
    return state.why_still if transport["state"] in ("stopped", "paused") and not state.resumes else ""


def _explained(state: SessionState, line: str, resumes: Resumes | None) -> StateAndActs:
    """Show pages the reason why real robots stand, and from where they may continue, if that is new."""
    if (line, resumes) == (state.why_still, state.resumes):
        return state, []
    shown: WhyStill = {"type": "why_still", "line": line}
    if resumes:
        shown["resumes"] = resumes
    return replace(state, why_still=line, resumes=resumes), _show(state, shown)


def _enter(state: SessionState, play: PlayScore, entered: TransportMessage, whole: bool = False) -> StateAndActs:
    """Have the twin play a score from exactly where the leading stage began with it."""
    play = replace(_shown(play), when="restart" if entered["restarted"] == play.generation else "now")
    if play.score.open:
        state = replace(state, behind=BEHIND)
    elif play.when == "restart":
        state = replace(state, behind=0.0)
    entry = entry_at(entered, entered["beat"], entered["monotonic"] + state.behind)
    if state.behind:
        entry["behind"] = state.behind
    return state, [SendScore([StageKey(HERE, "simulator")], play, entry, whole=whole)]


def _shown(play: PlayScore) -> PlayScore:
    """Return a score for a stage that only shows what another stage plays, and follows the senses there."""
    return replace(play, senses=None, anyway=False, arming=None, by=None)


def _send_again(state: SessionState, stage: StageKey, generation: int, now: Now) -> StateAndActs:
    """Send a stage the whole score: it lacks the score on which this one builds."""
    latest = state.latest
    if latest and latest.generation == generation:
        if stage.output == state.leader:
            return state, [SendScore([stage], latest, stops={stage: now.known}, asked=True, whole=True)]
        if stage.output == "page":
            return state, [SendScore([stage], _shown(latest), whole=True)]
        if stage.output == state.twin and state.entered:
            return _enter(state, latest, state.entered, whole=True)
    return state, []


def _loaded(state: SessionState, play: PlayScore, now: Now) -> StateAndActs:
    if play.generation == state.generation:  # the same score was sent again
        return state, []
    wanted = play.score.clock if play.score.clock and play.score.clock.follow != "ros" else None
    listens: list[Act] = [HearClock(wanted, float(play.score.tempo))] if wanted != state.clock else []
    pages = [key for key in state.stages if key.output == "page"]
    state = replace(state, played=play, latest=play, generation=play.generation, is_on=True, entered=None, clock=wanted)
    state = replace(state, stood=None)
    if state.is_real:
        state = on_hosts.plays(state, play, now) if state.is_spread else replace(state, on_robots=play)
    for key, stage in state.stages.items():
        if key.output == state.leader and stage.alive:
            state = state.with_stage(key, died_moving=False, only_halts=False)
    return state, [*([SendScore(pages, _shown(play))] if pages else []), *listens]


def _gone(state: SessionState, stage: StageKey, gone: Gone, now: Now) -> StateAndActs:
    """Replace a stage that has died, and report that. A new stage of real robots first stops them, even if a standby
    should have: that one may have failed too. Then people may have them resume from where they were."""
    leads, idles = stage.output == state.leader, stage.output == state.idle
    shown = not leads and not idles
    before = state.stages.get(stage, StageState())
    acts: list[Act] = []
    if leads:
        acts += _to(state.twin, {"type": "stop"})
        state = replace(state, stood=stood(state, now))
        if state.armed:
            acts += _show(state, {"type": "armed", "generation": state.generation, "armed": False, "begins": None})
        state = replace(state, is_on=False, waits_for=())
    if stage.output == "ros":
        state = stopped(without(state, stage.host))
    moved = not shown and bool(state.editions.sent)
    dead = replace(before, alive=False, armed=False, may_move=False, died_moving=moved)
    state = replace(state, stages={**state.stages, stage: dead}, latest=state.latest if idles else None)
    again = "" if idles else "; play again"
    if before.only_halts:  # another one would fail too
        what = f": robots may still be moving{again}" if before.died_moving else again
    else:
        acts.append(Start(stage))
        what = ": a new one will show what plays next" if shown else f": a new one is stopping the robots{again}"
    return state, [*acts, Announce({**gone, "message": f"{gone['message']}{what}"}, leads)]


def _started(state: SessionState, stage: StageKey, ready: Ready, now: Now) -> StateAndActs:
    """Send a new stage all that it has to know. In place of a dead one, it stops the robots, or joins the others."""
    real, before = stage.output == "ros", state.stages.get(stage, StageState())
    halts = before.died_moving and state.mode == "stopped"
    fresh = replace(before, ready=ready, alive=True, armed=False, transport=None, may_move=False, misplaced={})
    fresh = replace(fresh, died_moving=halts, only_halts=halts)
    state = replace(state, stages={**state.stages, stage: fresh})
    acts: list[Act] = [
        Send(stage, for_pages(kept) if kept["type"] == "program" or kept["type"] == "source" else kept)
        for kept in state.kept.values()
        if stage.host == HERE or kept["type"] in COMMANDS
    ]
    pressed = before.pressed if before.pressed["count"] else on_hosts.pressed_of(state, stage.host, now.pressed)
    if real and pressed["count"]:
        acts.append(Send(stage, pressed))
    if halts:
        acts.append(halt(state, stage))
        if state.pending and stage.output == state.leader:
            state, more = send_score(replace(state, pending=None), state.pending, now)
            acts += more
        return state, acts
    state, joins = _as_one(on_hosts.join(state, stage.host, now)) if real else (state, [])
    return state, [*acts, *joins]


def _not_started(state: SessionState, stage: StageKey, why: str) -> StateAndActs:
    leads, idles = stage.output == state.leader, stage.output == state.idle
    told = Announce({"type": "error", "message": f"no new stage could be started: {why}"}, leads)
    if idles:
        return state, [told]  # after a dead stage, the next play starts all stages
    stages = {other: each for other, each in state.stages.items() if other != stage}
    if leads:
        state = replace(state, leader=None, stood=None, pending=None)
    return replace(state, stages=stages), [told]
