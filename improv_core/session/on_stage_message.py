"""Decides about what stages report, their starts, and their ends: `(state, name, message, now) -> (state, acts)`,
without side effects. Standard library only."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from improv_core.ipc.stage_process import Gone, Heard
from improv_core.music.clock_process import HeardClock
from improv_core.protocol.clock_messages import BendMessage
from improv_core.protocol.messages import Decided as SenseDecided
from improv_core.protocol.messages import Obeyed, Ready, Sensed, ToStage, TransportMessage
from improv_core.protocol.page_messages import ForPages, for_pages
from improv_core.protocol.play_again import stop_of
from improv_core.protocol.robot_messages import FaultMessage
from improv_core.score.score import Part, Score
from improv_core.score.takeover import Takeover
from improv_core.session.acts import Act, Announce, Failed, HearClock, Loaded, Send, SendScore, StartAgain
from improv_core.session.on_request import Decided, Now, asked, obeyed
from improv_core.session.start import SinkName
from improv_core.session.state import Kept, PlayScore, SessionState

BEHIND = 0.1
"""Seconds by which the simulator plays a score with senses behind real robots: their decisions have to arrive first."""


def heard(state: SessionState, name: SinkName, message: Heard | Loaded | Failed, now: Now) -> Decided:
    """Return the state after a stage has sent a message, has started, or has ended, and the acts that follow."""
    after, acts = _heard(state, name, message, now)
    if after.obeys and not state.obeys:  # the robots of a dead stage stand
        acts += [act for mark in sorted(after.unobeyed) for act in obeyed(after, mark)]
        after = replace(after, unobeyed=frozenset())
    return after, acts


def _heard(state: SessionState, name: SinkName, message: Heard | Loaded | Failed, now: Now) -> Decided:
    leads = state.leads(name)
    if message["type"] == "request":
        return asked(state, message["command"], now)
    if message["type"] == "lacks":
        return _send_again(state, name, message["generation"])
    if message["type"] == "obeyed":
        return _obeyed(state, message)
    if message["type"] == "loaded":
        return _loaded(state, message["play"])
    if message["type"] == "ready":
        return _started(state, name, message, now)
    if message["type"] == "failed":
        return _not_started(state, name, message["message"])
    if message["type"] == "gone":
        return _gone(state, name, message)
    acts: list[Act] = []
    if message["type"] == "transport":
        state, acts = _followed(state, name, message)
        acts += _show(state, message) if leads and not state.twin else []
    elif message["type"] == "sensed" or message["type"] == "decided":
        if not leads:
            return state, []
        acts = _follow(state, message)
    elif message["type"] == "fault" and leads:
        acts = _follow(state, message)
        if message["response"] == "stand" and not message["over"]:
            state = state.with_muted(message["robot"])
    elif leads and (
        message["type"] == "measured"
        or message["type"] == "joints"
        or message["type"] == "vitals"
        or message["type"] == "link"
    ):
        acts = _show(state, message)
    elif message["type"] == "misplaced":
        # The twin waits, too: it may still play the previous score.
        pause: list[Act] = _to(state.twin, {"type": "pause"}) if leads and message["robots"] else []
        acts = [*pause, *_show(state, message)] if leads else []
    elif message["type"] == "unreached" and leads:
        state, acts = _explained(state, message["message"])
    elif message["type"] == "armed" and leads:
        state, acts = replace(state, armed=message["armed"]), _show(state, message)
    return state, [*acts, Announce(message, leads)]


def _obeyed(state: SessionState, message: Obeyed) -> Decided:
    """Inform pages that real robots have obeyed a stop, or which of their stages have yet to."""
    if not message["waits_for"] and not state.obeys:
        return state, []  # the new stage never moved the robots of the dead one
    unobeyed = state.unobeyed if message["waits_for"] else state.unobeyed - {message["mark"]}
    return replace(state, unobeyed=unobeyed), obeyed(state, message["mark"], message["waits_for"])


def _to(name: SinkName | None, message: ToStage) -> list[Act]:
    return [Send(name, message)] if name else []


def _show(state: SessionState, message: ForPages) -> list[Act]:
    """Show a report of the leading stage on pages that don't get it from that stage itself."""
    return _to(state.onlooker, for_pages(message))


def _follow(state: SessionState, message: Sensed | SenseDecided | FaultMessage) -> list[Act]:
    """Have the twin do the same as real robots; it shows that, too."""
    return _to(state.twin, message) if state.twin else _show(state, message)


def _followed(state: SessionState, name: SinkName, transport: TransportMessage) -> Decided:
    """Start the twin at exactly the same time as the leading stage, and stop and pause it when that one does."""
    mode, waited, latest = transport["state"], state.waits_for, state.latest
    if name == state.halting and mode in ("stopped", "ended") and transport["generation"] == state.generation:
        state = replace(state, still=True)  # before it was sent its score, it had nothing to stop
    if not state.leads(name):
        return state, []
    state, acts = _explained(state, _why_still(state, transport))
    state = replace(
        state,
        is_on=mode in ("waiting", "playing", "paused"),
        waits_for=transport.get("waits_for", transport.get("too_near", ())),
        editions=state.editions.plays(transport["generation"]),
    )
    if state.twin and mode == "playing":
        if latest and not state.entered and transport["generation"] == latest.generation:
            state, enters = _enter(replace(state, entered=transport), state.twin, latest, transport)
            return state, [*enters, *_bends(state, transport), *acts]
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
    if not state.twin or "pace" not in transport:
        return []
    at = transport["monotonic"] + state.behind
    bend: BendMessage = {"type": "bend", "at": at, "beat": transport["beat"], "pace": transport["pace"]}
    return [Send(state.twin, bend, state.behind)]


def _why_still(state: SessionState, transport: TransportMessage) -> str:
    """Return the reason why real robots stand, for pages. The reason for a stop stays until something else plays."""
    if near := transport.get("too_near"):
        return f"Too near to each other: {', '.join(near)}. Make room, then press Play."
    if transport["state"] == "paused" and (waits := transport.get("waits_for")):
        return f"Waiting for {', '.join(waits)}."
    return state.why_still if transport["state"] in ("stopped", "paused") else ""


def _explained(state: SessionState, line: str) -> Decided:
    """Show pages the reason why real robots stand, if it is new."""
    if line == state.why_still:
        return state, []
    return replace(state, why_still=line), _show(state, {"type": "why_still", "line": line})


def _enter(
    state: SessionState, twin: SinkName, play: PlayScore, entered: TransportMessage, whole: bool = False
) -> Decided:
    """Have the twin play a score from exactly where the leading stage began with it."""
    play = replace(play, when="restart" if entered["restarted"] == play.generation else "now")
    if play.score.open:
        state = replace(state, behind=BEHIND)
    elif play.when == "restart":
        state = replace(state, behind=0.0)
    entry: Takeover = {"beat": entered["beat"], "monotonic": entered["monotonic"] + state.behind}
    if "begins" in entered:
        entry["begins"] = entered["begins"]
    if "scene" in entered:
        entry["scene"] = entered["scene"]
    if "pace" in entered:
        entry["pace"] = entered["pace"]
    if state.behind:
        entry["behind"] = state.behind
    return state, [SendScore(twin, play, entry, whole=whole)]


def _send_again(state: SessionState, name: SinkName, generation: int) -> Decided:
    """Send a stage the whole score: it did not get the one on which this score builds."""
    latest = state.latest
    if latest and latest.generation == generation:
        if name == state.leader:
            return state, [SendScore(name, latest, asked=True, whole=True)]
        if name == "page":
            return state, [SendScore(name, latest, whole=True)]
        if name == state.twin and state.entered:
            return _enter(state, name, latest, state.entered, whole=True)
    return state, []


def heard_clock(state: SessionState, message: HeardClock) -> Decided:
    """Return the state after news of a clock of music, which the leading stage follows, and the acts that follow."""
    if message["type"] == "anchor":
        return state, _to(state.leader, message)
    if message["type"] == "warning":
        return state, [Announce({"type": "warning", "message": message["message"]})]
    if message["type"] == "error":
        return state, [Announce(message)]
    line = f"the clock is lost: {message['message']}" if message["message"] else ""
    said: list[Act] = [Announce({"type": "error", "message": line})] if line else []
    return replace(state, clock=None), [HearClock(None), *said]


def _loaded(state: SessionState, play: PlayScore) -> Decided:
    if play.generation == state.generation:  # the same score was sent again
        return state, []
    clock = play.score.clock if play.score.clock and play.score.clock.follow != "ros" else None
    listens: list[Act] = [HearClock(clock, float(play.score.tempo))] if clock != state.clock else []
    state = replace(
        state, played=play, latest=play, generation=play.generation, is_on=True, entered=None, halting=None, still=True
    )
    shows: list[Act] = [SendScore("page", play)] if "page" in state.stages else []
    return replace(state, clock=clock), [*shows, *listens]


def _gone(state: SessionState, name: SinkName, gone: Gone) -> Decided:
    """Replace a stage that has died, and report that. A new stage of real robots first stops them, even if a standby
    should have: that one may have failed too."""
    leads, idles = state.leads(name), name == state.idle
    acts: list[Act] = []
    state = replace(state, gone=state.gone | {name}, latest=state.latest if idles else None)
    if leads:
        state = replace(state, is_on=False, waits_for=())
        acts += _to(state.twin, {"type": "stop"})
        if state.armed:
            acts += _show(state, {"type": "armed", "generation": state.generation, "armed": False, "begins": None})
            state = replace(state, armed=False)
    again = "" if idles else "; save to play again"
    if name == state.halting:  # another one would fail too
        what = again if state.still else f": robots may still be moving{again}"
        state = replace(state, still=True)
    else:
        acts.append(StartAgain(name))
        shown = not leads and not idles
        what = ": a new one will show the next dance" if shown else f": a new one is stopping the robots{again}"
    return state, [*acts, Announce({**gone, "message": f"{gone['message']}{what}"}, leads)]


def _started(state: SessionState, name: SinkName, ready: Ready, now: Now) -> Decided:
    """Send a new stage all that it has to know. In place of a dead one, it stops the robots."""
    halts = state.halts(name)
    state = replace(state, stages={**state.stages, name: ready}, gone=state.gone - {name})
    acts: list[Act] = [Send(name, _kept(message)) for message in state.kept.values()]
    if ready["real"] and now.pressed["count"]:
        acts.append(Send(name, now.pressed))
    if halts:
        idle_score = state.idle_score if name == state.idle else None
        scores = [idle_score] if idle_score else [*state.editions.sent.values()]
        state = replace(state, halting=name, still=False)
        acts.append(SendScore(name, PlayScore(_standing(scores), "", 0, generation=state.generation)))
    return state, acts


def _kept(message: Kept) -> ToStage:
    return for_pages(message) if message["type"] == "program" or message["type"] == "source" else message


def _not_started(state: SessionState, name: SinkName, why: str) -> Decided:
    told = Announce({"type": "error", "message": f"no new stage could be started: {why}"}, name == state.leader)
    if name == state.idle:
        return state, [told]  # after a dead stage, the next play starts all stages
    stages = {other: ready for other, ready in state.stages.items() if other != name}
    leader = None if name == state.leader else state.leader
    return replace(state, stages=stages, gone=state.gone - {name}, leader=leader), [told]


def _standing(scores: Collection[Score]) -> Score:
    """Return a score with the robots of these scores, any of which may play, and with nothing to play, so that they are
    only sent zeros.

    A robot may have another topic in each score. Then it counts as several.
    """
    robots = {part.topic: part for score in scores for part in score.moving().parts.values()}
    parts: dict[str, Part] = {}
    for topic, part in robots.items():
        name = topic if part.robot in parts else part.robot
        parts[name] = replace(part, robot=name, scenes=(), reset=None)
    latest = [*scores][-1]
    return Score(latest.tempo, parts, world=latest.world)
