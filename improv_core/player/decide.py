"""Decides what follows from an event: `(run, event, facts) -> (run, acts)`. Nothing here does anything.

If an act fails, the acts after it are left out, and the run is already the one that was decided. So acts that may fail
come first, and an event of its own reports that they are done (`Then`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

from improv_core.player import events, start_gate, start_rules, stop_rules, tempo_rules
from improv_core.player.acts import (
    Act,
    CheckNow,
    CheckSoon,
    CreatePublishers,
    Dismiss,
    DriveBack,
    Drop,
    ForgetEdges,
    Place,
    Prepare,
    PrepareRestart,
    ReadmitRobots,
    Rejoin,
    Report,
    Resend,
    Rest,
    SendUntil,
    Tell,
    Then,
)
from improv_core.player.agenda import Due, Rank
from improv_core.player.events import Event, Facts, Internal, Message
from improv_core.player.run import EMPTY, Run, Silenced
from improv_core.player.start_rules import begin_parts, comes_in, coming_in, in_time, play_from, waits
from improv_core.player.stop_rules import RunAndActs, error_line, warning_line
from improv_core.protocol.commands import Silence
from improv_core.protocol.fields import FASTEST, LAST_BEAT, SLOWEST
from improv_core.protocol.limits import MAX_AHEAD
from improv_core.protocol.messages import Play
from improv_core.protocol.play_again import STOPPED
from improv_core.safety import preflight
from improv_core.score.motion import STILL
from improv_core.score.movement import Exact, near
from improv_core.score.peer_clock import Anchor
from improv_core.score.score import Score
from improv_core.score.seeking import TooFarError, arrive
from improv_core.score.takeover import OutgoingScore, PendingTakeover, edited, entering

SEEN = 0.5
"""Seconds after a fault for which unmuting the robot has no effect: nobody can know yet that it stands."""
UNHEARD = "no robot listened, so none has moved: start their drivers, check them with `improv doctor`, and play again"
LATE = 0.5
"""Seconds by which setpoints may be late. After that, real robots are stopped: they have stopped, or should have."""

TOO_FAR = "can't jump to beat {beat:,g}: it takes too long to find out what {robot} does there, so jump less far"


def decide(run: Run, event: Event, facts: Facts) -> RunAndActs:
    """Return the performance after an event, and the acts to do, in this order."""
    then, acts = _asked(run, event, facts) if isinstance(event, dict) else _RULES[type(event)](run, event, facts)
    if then.misplaced is not None and then.mode != "paused":
        then, acts = replace(then, misplaced=None), [*acts, Tell(preflight.message(None, then.generation))]
    if (then.gate or then.is_due) and then.mode != "waiting":
        then = replace(then, gate=None, is_due=False)
    if then.gate is not run.gate and start_gate.is_news(run.gate, then.gate):
        acts = [*acts, Tell(start_gate.message(then.gate, then.generation))]
    return then, acts


def _asked(run: Run, message: Message, facts: Facts) -> RunAndActs:
    match message["type"]:
        case "stop":
            return stop_rules.stop(run, facts, message.get("by"), unasked=message.get("unasked", False))
        case "pause":
            return stop_rules.pause(run, facts)
        case "resume":
            by, anyway = message.get("by"), message.get("anyway", False)
            if "beat" not in message or not run.may_start(by):
                return start_rules.resume(run, facts, by, anyway=anyway)
            run, acts = _seek(run, message["beat"], facts)
            run, more = start_rules.resume(run, facts, by, anyway=anyway)
            return run, [*acts, *more]
        case "seek":
            return _seek(run, message["beat"], facts)
        case "speed":
            return _speed(run, message["factor"], facts)
        case "silence":
            return _silence(run, message, facts)
        case "pressed":
            return replace(run, stops=run.stops.merged(message)), []
        case "bend":
            return tempo_rules.bend(run, message, facts)
        case "fault":  # of a real robot, whose simulated twin stands with it
            stands = message["response"] == "stand" and not message["over"]
            return stop_rules.stand(run, message["robot"], facts) if stands else (run, [])


def trouble(run: Run, real: bool, late: float, overloaded: bool) -> Event | None:
    """Return the reason to stop moving real robots: setpoints are too `late`, or this machine is `overloaded`."""
    if not real or run.mode != "playing":
        return None
    if late > LATE:
        return events.Stalled(late)
    return events.Overloaded() if overloaded else None


def _play(run: Run, play: Play, facts: Facts) -> RunAndActs:
    """Return what follows from a score to play: it restarts, or takes over from the one that plays.

    A score that moves real robots is refused while an emergency stop is on, or if one was pressed after the request.
    One that an automation requests is refused after a stop that wasn't its own.
    """
    load, score, performed, by = play.load, play.score, run.transport.performed(facts.now), play.load.get("by")
    moves, entry = score.moves, load.get("entry")
    if "stood" in load:
        return run, [PrepareRestart(play), Then(events.Restarted(play))]
    if moves and facts.real and (line := run.stops.refusal(score.safety, load.get("stops"))):
        return run, [error_line(line), Report()]
    if moves and not run.may_start(by):
        return run, [warning_line(STOPPED), Report()]
    run = run.started(by) if moves else run
    continues = run.mode in ("playing", "paused") or (run.mode == "ended" and entry)
    if load["when"] == "restart" or not continues:
        return run, [PrepareRestart(play), Then(events.Restarted(play))]
    if entry:
        at = entry["monotonic"] - run.transport.zero
    elif run.mode == "paused":
        at = performed
    else:
        soonest = max(facts.now, min(load.get("at", facts.now), facts.now + MAX_AHEAD))
        soonest = run.transport.performed(soonest - facts.late)  # when it does in other stages, even if it comes late
        at = run.switch_time(load["when"], soonest, play.beats_per_bar, facts.over)
    swap = PendingTakeover(score, load["generation"], load["when"], play.beats_per_bar, at, entry)
    if run.mode == "paused":
        return _take_over(run, swap, facts)
    return replace(run, next=swap), [CreatePublishers(score)]


def _awaited(run: Run, event: events.Awaited, facts: Facts) -> RunAndActs:
    """Begin if nothing is left to wait for, unless this stage hung when real robots had to begin by themselves."""
    opened = run.gate and run.gate.ready and run.gate.late(facts.now, facts.wall) >= 0
    if facts.real and opened and event.late > LATE:
        return stop_rules.stalled(run, events.Stalled(event.late), facts)
    return start_rules.awaited(run, event, facts)


def _seek(run: Run, asked: float, facts: Facts) -> RunAndActs:
    if run.score is EMPTY or run.mode == "waiting":
        return run, []
    passed = facts.late / run.beat_period if run.mode == "playing" else 0.0
    there, last = min(max(asked, 0.0) + passed, LAST_BEAT), run.begun.beats
    beat = near(there) if isinstance(last, float) or there < last else last
    try:
        poses = arrive(run.begun, beat, facts.paths)
    except TooFarError as error:
        return run, [warning_line(TOO_FAR.format(beat=float(beat) + 1, robot=error.robot))]
    run = run.at_scene_of(run.begun, beat)
    acts: list[Act] = [Dismiss(), ForgetEdges()]
    if run.mode == "playing" and comes_in(run):
        run, stands = stop_rules.leave(run, "paused", facts)
        run = coming_in(replace(run.left_at(beat), continues=True), facts)
        return run, [*stands, *acts, Place(beat, poses), Report()]
    if run.mode == "playing":
        places = {each: preflight.Standing(poses[each], at.pose) for each, at in facts.places.items() if each in poses}
        run, more = play_from(run, beat, run.transport.performed(facts.now), facts, places)
        return run, [*acts, Place(beat, poses), *more]
    return replace(run.left_at(beat), mode="paused"), [*acts, Place(beat, poses), Report()]


def _speed(run: Run, factor: float, facts: Facts) -> RunAndActs:
    beat = run.later(run.beat(facts.now, facts.over), -facts.late)
    run = replace(run, speed=Fraction(str(min(max(factor, SLOWEST), FASTEST))))
    if run.mode == "playing":
        beat = run.later(beat, facts.late)
        return play_from(run, beat, run.transport.performed(facts.now), facts)
    return replace(run, transport=replace(run.transport, tempo=run.tempo)), [Report()]


def _returning(run: Run, event: events.Returning, facts: Facts) -> RunAndActs:
    acts: list[Act] = []
    for robot, twist, line in event.steps:
        acts += [DriveBack(robot, twist)] if twist is not None else [Rejoin(robot), Resend([robot])]
        acts += [warning_line(line)] if line else []
    return run, acts


def _silence(run: Run, asked: Silence, facts: Facts) -> RunAndActs:
    muted = frozenset(asked["muted"])
    stood = {robot: at for robot, at in run.stood.items() if robot in muted or facts.now < at + SEEN}
    then = replace(run, silenced=Silenced(muted, frozenset(asked["soloed"])), stood=stood)
    changed = [
        robot
        for robot in (run.score.parts if run.mode == "playing" else ())
        if run.stands(robot, facts.standing) != then.stands(robot, facts.standing)
    ]
    return then, [*([Resend(changed)] if changed else []), Report()]


def _due(run: Run, due: Due, facts: Facts) -> RunAndActs:
    if due.rank == Rank.TAKEOVER:
        assert run.next
        return _take_over(run, run.next, facts)
    if due.rank == Rank.BEND:
        return tempo_rules.looked(run, due, facts)
    beat = run.ends(facts.over)
    assert not isinstance(beat, float)
    if due.rank == Rank.SCENE:
        return _next_scene(run, beat, due.at, facts)
    if run.next and run.next.at == math.inf:
        return _take_over(run, replace(run.next, at=due.at), facts)
    if facts.unheard and run.score.moves:
        stopped, acts = stop_rules.leave(run, "stopped", facts)
        return replace(stopped, startable_by=run.startable_by), [error_line(UNHEARD), *acts]
    run = replace(run, mode="ended", transport=replace(run.transport, since=due.at, origin=beat))
    returns = run.score.parts.keys() & facts.standing if run.score.safety.rejoin == "return" else ()
    # A bump in the last second is reported before the end.
    return run, [
        Rest(),
        *(DriveBack(robot, STILL) for robot in returns),
        *([] if facts.real else [CheckNow(run.score.parts)]),
        Report(),
    ]


def _next_scene(run: Run, beat: Exact, at: float, facts: Facts) -> RunAndActs:
    scene, score = run.scene + 1, run.score
    if score.open:  # the beat was not known in advance: count from there
        parts = {
            robot: replace(part, begins=beat, scene=scene, scene_begins=(), entered=facts.poses.get(robot))
            for robot, part in score.parts.items()
        }
        score = replace(score, parts=parts, scene=scene, since=beat)
    run = replace(run, score=score, scene=scene)
    back: list[Act] = [ReadmitRobots()] if score.safety.rejoin == "scene" else []
    # The scene is reported only if its beat was not known in advance.
    return run, [*back, Dismiss(), *begin_parts(run, score.parts, beat, at, tells=score is not run.begun)]


def _take_over(run: Run, swap: PendingTakeover, facts: Facts) -> RunAndActs:
    """Have a score take over. Parts that stay the same play on: what is due in them is sent first."""
    old = run.score
    paused = run.mode == "paused"
    beat = run.transport.origin if paused and not swap.entry else swap.beat(run.transport)
    before = OutgoingScore(old, run.scene, run.is_over(beat, facts.over), None if facts.real else facts.poses)
    score = edited(swap, beat, before)
    begin, leaving = entering(score, before), old.parts.keys() - score.parts.keys()
    keeps_playing = run.mode == "playing" and _same_time(score, old) and not swap.shifts(run.transport)
    replaced = events.Replaced(score, swap.generation, swap.at, beat, begin, leaving, keeps_playing, swap.entry)
    return replace(run, next=None), [
        Drop({*begin, *leaving} if keeps_playing else {*old.parts, *score.parts}),
        SendUntil(swap.at),
        Prepare(score, begin, swap.at),
        Then(replaced),
    ]


def _same_time(score: Score, old: Score) -> bool:
    """Return whether two scores have the same tempo and follow the same clock."""
    return score.tempo == old.tempo and score.clock == old.clock


def _replaced(run: Run, event: events.Replaced, facts: Facts) -> RunAndActs:
    score, begin, old = event.score, event.entering, run.score.parts
    on_new_topics = [robot for robot in score.parts if robot in old and old[robot].topic != score.parts[robot].topic]
    run = replace(run, score=score, begun=score, scene=score.scene, generation=event.generation)
    run = in_time(run, event.entry, facts)
    if event.keeps_playing and not waits(run, facts):
        acts = begin_parts(run, begin, event.beat, event.at)
        if others := [robot for robot in on_new_topics if robot not in begin]:  # their parts continue on other topics
            acts += [
                Resend(others),
                *(warning_line(f"{score.parts[each].topic} has the part of {each} now") for each in others),
            ]
    elif run.mode == "paused" and comes_in(run):
        run, acts = coming_in(replace(run.left_at(event.beat), continues=True), facts), [Report()]
    else:
        run, acts = play_from(run, event.beat, event.at, facts, {} if run.mode == "playing" else facts.places)
    return run, [Dismiss({*begin, *event.leaving}), *acts, CheckSoon({*begin, *on_new_topics})]


_RULES: Mapping[type[Internal], Callable[[Run, Any, Facts], RunAndActs]] = {
    Play: _play,
    events.Restarted: start_rules.restarted,
    events.Awaited: _awaited,
    events.Listened: start_rules.listened,
    events.Replaced: _replaced,
    events.EmergencyStop: stop_rules.emergency_stop,
    events.Halted: stop_rules.halted,
    events.Changed: start_rules.changed,
    events.Stalled: stop_rules.stalled,
    events.Overloaded: stop_rules.overloaded,
    events.Faults: stop_rules.faults,
    events.TooNear: stop_rules.too_near,
    events.Returning: _returning,
    Anchor: tempo_rules.anchored,
    Due: _due,
}
