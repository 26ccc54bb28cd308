"""What follows from what stages say, start, and end: `(show, name, message, now) -> (show, acts)`.

Nothing here does anything. Standard library only.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

from improv_core.ipc.stage_process import Gone, Heard
from improv_core.music.clock_process import HeardClock
from improv_core.protocol.clock_messages import BendMessage
from improv_core.protocol.messages import Armed, Obeyed, Ready, Takeover, ToStage, TransportMessage
from improv_core.protocol.play_again import stop_of
from improv_core.score.score import Part, Score
from improv_core.session.acts import Act, Announce, Failed, HearClock, Loaded, Send, SendScore, StartAgain
from improv_core.session.on_request import Decided, Now, asked, obeyed
from improv_core.session.start import SinkName
from improv_core.session.state import PlayScore, Show

BEHIND = 0.1
"""Seconds by which the simulator plays a score with senses behind real robots: what they decide has to arrive first."""


def heard(show: Show, name: SinkName, message: Heard | Loaded | Failed, now: Now) -> Decided:
    """What is known once a stage has said something, has started, or is gone, and what to do about it."""
    after, acts = _heard(show, name, message, now)
    if after.obeys and not show.obeys:  # the robots of a dead stage stand
        acts += [act for mark in sorted(after.unobeyed) for act in obeyed(after, mark)]
        after = replace(after, unobeyed=frozenset())
    return after, acts


def _heard(show: Show, name: SinkName, message: Heard | Loaded | Failed, now: Now) -> Decided:
    leads = show.leads(name)
    if message["type"] == "request":
        return asked(show, message["command"], now)
    if message["type"] == "lacks":
        return _send_again(show, name, message["generation"])
    if message["type"] == "obeyed":
        return _obeyed(show, message)
    if message["type"] == "loaded":
        return _loaded(show, message["play"])
    if message["type"] == "ready":
        return _started(show, name, message, now)
    if message["type"] == "failed":
        return _not_started(show, name, message["message"])
    if message["type"] == "gone":
        return _gone(show, name, message)
    acts: list[Act] = []
    if message["type"] == "transport":
        show, acts = _followed(show, name, message)
    elif message["type"] == "sensed" or message["type"] == "decided":
        if not leads:
            return show, []
        acts = _to(show.twin, message)
    elif leads and (
        message["type"] == "measured"
        or message["type"] == "joints"
        or message["type"] == "fault"
        or message["type"] == "vitals"
        or message["type"] == "link"
    ):
        acts = _to(show.twin, message)
        if message["type"] == "fault" and message["response"] == "stand" and not message["over"]:
            show = show.with_muted(message["robot"])
    elif message["type"] == "misplaced":
        # The twin waits, too: it may still play what was played before.
        pause: list[Act] = _to(show.twin, {"type": "pause"}) if leads and message["robots"] else []
        acts = [*pause, *_to(show.twin, message)] if leads else []
    elif message["type"] == "unreached" and leads:
        show, acts = _explained(show, message["message"])
    elif message["type"] == "armed" and leads:
        show, acts = replace(show, armed=message["armed"]), _to(show.twin, message)
    return show, [*acts, Announce(message, leads)]


def _obeyed(show: Show, message: Obeyed) -> Decided:
    """Let pages know that real robots have obeyed a stop, or who has yet to."""
    if not message["waits_for"] and not show.obeys:
        return show, []  # it never moved those of the dead stage
    unobeyed = show.unobeyed if message["waits_for"] else show.unobeyed - {message["mark"]}
    return replace(show, unobeyed=unobeyed), obeyed(show, message["mark"], message["waits_for"])


def _to(name: SinkName | None, message: ToStage) -> list[Act]:
    return [Send(name, message)] if name else []


def _followed(show: Show, name: SinkName, transport: TransportMessage) -> Decided:
    """Start the twin at exactly the same time as the leading stage, and stop and pause it when that one does."""
    state, waited, latest = transport["state"], show.waits_for, show.latest
    if name == show.halting and state in ("stopped", "ended") and transport["generation"] == show.generation:
        show = replace(show, still=True)  # before it was sent its score, it had nothing to stop
    if not show.leads(name):
        return show, []
    show, acts = _explained(show, _why_still(show, transport))
    show = replace(
        show,
        is_on=state in ("waiting", "playing", "paused"),
        waits_for=transport.get("waits_for", transport.get("too_near", ())),
        editions=show.editions.plays(transport["generation"]),
    )
    if show.twin and state == "playing":
        if latest and not show.entered and transport["generation"] == latest.generation:
            show, enters = _enter(replace(show, entered=transport), show.twin, latest, transport)
            return show, [*enters, *_bends(show, transport), *acts]
        resumes = _to(show.twin, {"type": "resume", "at": transport["monotonic"]}) if waited else []
        return show, [*resumes, *_bends(show, transport), *acts]
    if state == "stopped":
        return show, [*_to(show.twin, stop_of(transport)), *acts]
    if state == "paused" and show.waits_for:
        pauses = _to(show.twin, {"type": "pause", "at": transport["monotonic"]})
        if "pace" in transport and latest and not latest.score.open:  # perhaps back to where a clock stood still
            pauses += _to(show.twin, {"type": "seek", "beat": transport["beat"]})
        return show, [*pauses, *acts]
    return show, acts


def _bends(show: Show, transport: TransportMessage) -> list[Act]:
    """Have the twin play as fast as the leading stage, which follows a clock from outside."""
    if not show.twin or "pace" not in transport:
        return []
    at = transport["monotonic"] + show.behind
    bend: BendMessage = {"type": "bend", "at": at, "beat": transport["beat"], "pace": transport["pace"]}
    return [Send(show.twin, bend, show.behind)]


def _why_still(show: Show, transport: TransportMessage) -> str:
    """What pages say about why real robots stand. What was said at a stop stays until something else plays."""
    if near := transport.get("too_near"):
        return f"Too near to each other: {', '.join(near)}. Make room, then press Play."
    if transport["state"] == "paused" and (waits := transport.get("waits_for")):
        return f"Waiting for {', '.join(waits)}."
    return show.why_still if transport["state"] in ("stopped", "paused") else ""


def _explained(show: Show, line: str) -> Decided:
    """Tell pages why real robots stand, if they don't know that."""
    if line == show.why_still:
        return show, []
    return replace(show, why_still=line), _to(show.twin, {"type": "why_still", "line": line})


def _enter(show: Show, twin: SinkName, play: PlayScore, entered: TransportMessage, whole: bool = False) -> Decided:
    """Have the twin play a score from exactly where the leading stage began with it."""
    play = replace(play, when="restart" if entered["restarted"] == play.generation else "now")
    if play.score.open:
        show = replace(show, behind=BEHIND)
    elif play.when == "restart":
        show = replace(show, behind=0.0)
    entry: Takeover = {"beat": entered["beat"], "monotonic": entered["monotonic"] + show.behind}
    if "begins" in entered:
        entry["begins"] = entered["begins"]
    if "scene" in entered:
        entry["scene"] = entered["scene"]
    if "pace" in entered:
        entry["pace"] = entered["pace"]
    if show.behind:
        entry["behind"] = show.behind
    return show, [SendScore(twin, play, entry, whole=whole)]


def _send_again(show: Show, name: SinkName, generation: int) -> Decided:
    """Send a stage the whole score: it did not get the one before, which this one counts on."""
    latest = show.latest
    if latest and latest.generation == generation:
        if name == show.leader:
            return show, [SendScore(name, latest, asked=True, whole=True)]
        if name == show.twin and show.entered:
            return _enter(show, name, latest, show.entered, whole=True)
    return show, []


def heard_clock(show: Show, message: HeardClock) -> Decided:
    """What follows from what is heard of a clock of music, which the stage that leads follows."""
    if message["type"] == "anchor":
        return show, _to(show.leader, message)
    if message["type"] == "warning":
        return show, [Announce({"type": "warning", "message": message["message"]})]
    if message["type"] == "error":
        return show, [Announce(message)]
    line = f"the clock can't be heard any more: {message['message']}" if message["message"] else ""
    said: list[Act] = [Announce({"type": "error", "message": line})] if line else []
    return replace(show, clock=None), [HearClock(None), *said]


def _loaded(show: Show, play: PlayScore) -> Decided:
    if play.generation == show.generation:  # it was sent again
        return show, []
    clock = play.score.clock if play.score.clock and play.score.clock.follow != "ros" else None
    listens: list[Act] = [HearClock(clock, float(play.score.tempo))] if clock != show.clock else []
    show = replace(
        show, played=play, latest=play, generation=play.generation, is_on=True, entered=None, halting=None, still=True
    )
    return replace(show, clock=clock), listens


def _gone(show: Show, name: SinkName, gone: Gone) -> Decided:
    """Replace a stage that has died, and say so.

    A new stage of real robots first stops them, even if a standby should have: that one may have failed too.
    """
    leads, idles = show.leads(name), name == show.idle
    acts: list[Act] = []
    show = replace(show, gone=show.gone | {name}, latest=show.latest if idles else None)
    if leads:
        show = replace(show, is_on=False, waits_for=())
        acts += _to(show.twin, {"type": "stop"})
        if show.armed:
            disarmed: Armed = {"type": "armed", "generation": show.generation, "armed": False, "begins": None}
            show, acts = replace(show, armed=False), [*acts, *_to(show.twin, disarmed)]
    again = "" if idles else "; save to play again"
    if name == show.halting:  # another one would fail too
        what = again if show.still else f": robots may still be moving{again}"
        show = replace(show, still=True)
    else:
        acts.append(StartAgain(name))
        shown = not leads and not idles
        what = ": a new one will show the next dance" if shown else f": a new one is stopping the robots{again}"
    return show, [*acts, Announce({**gone, "message": f"{gone['message']}{what}"}, leads)]


def _started(show: Show, name: SinkName, ready: Ready, now: Now) -> Decided:
    """Tell a new stage all that it has to know. In place of a dead one, it stops the robots."""
    replaces = name in show.gone
    show = replace(show, stages={**show.stages, name: ready}, gone=show.gone - {name})
    acts: list[Act] = [Send(name, message) for message in show.kept.values()]
    if ready["real"] and now.pressed["count"]:
        acts.append(Send(name, now.pressed))
    idle_score = show.idle_score if name == show.idle else None
    scores = [idle_score] if idle_score else [*show.editions.sent.values()]
    if replaces and scores and name != show.twin:
        show = replace(show, halting=name, still=False)
        acts.append(SendScore(name, PlayScore(_standing(scores), "", 0, generation=show.generation)))
    return show, acts


def _not_started(show: Show, name: SinkName, why: str) -> Decided:
    told = Announce({"type": "error", "message": f"no new stage could be started: {why}"}, name == show.leader)
    if name == show.idle:
        return show, [told]  # a dead one has the next play start all stages
    stages = {other: ready for other, ready in show.stages.items() if other != name}
    leader = None if name == show.leader else show.leader
    return replace(show, stages=stages, gone=show.gone - {name}, leader=leader), [told]


def _standing(scores: Collection[Score]) -> Score:
    """The robots of scores of which any may play, with nothing to play, so they are only told to stop.

    A robot may have another topic in each score. Then it counts as several.
    """
    robots = {part.topic: part for score in scores for part in score.moving().parts.values()}
    parts: dict[str, Part] = {}
    for topic, part in robots.items():
        name = topic if part.robot in parts else part.robot
        parts[name] = replace(part, robot=name, scenes=(), reset=None)
    latest = [*scores][-1]
    return Score(latest.tempo, parts, world=latest.world)
