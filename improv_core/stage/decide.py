"""What follows from what happens: `(run, event, facts) -> (run, acts)`. Nothing here does anything.

If an act fails, the acts after it are left out, and the run is already the one that was decided. So what may fail is
done first, and an event of its own says that it is done (`Then`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import Any

from improv_core.score.following import OLDEST
from improv_core.score.movement import Exact, near
from improv_core.score.path import pose_at
from improv_core.score.score import Score
from improv_core.score.transport import Transport
from improv_core.stage import events, gate, preflight
from improv_core.stage.acts import (
    Act,
    Begin,
    Dismiss,
    Drop,
    ForgetEdges,
    Listen,
    Look,
    LookLater,
    LookSoon,
    Meet,
    Place,
    Prepare,
    PrepareAnew,
    Report,
    ReportSenses,
    Resend,
    Rest,
    SendUntil,
    StartMeasuring,
    Still,
    Tell,
    TellFaults,
    Then,
    Welcome,
    Zero,
)
from improv_core.stage.agenda import Due, Rank
from improv_core.stage.events import Event, Facts
from improv_core.stage.faults import FaultBegan
from improv_core.stage.fields import FASTEST, LAST_BEAT, SLOWEST
from improv_core.stage.interlocks import pose_of, waits_for
from improv_core.stage.messages import refused_by
from improv_core.stage.nearness import as_line
from improv_core.stage.run import EMPTY, Mode, Run, Silenced
from improv_core.stage.swap import Before, Swap, edited, entering, joined

SEEN = 0.5
"""Seconds: whoever unmutes a robot this soon after a fault made it stand can't have known that it stands."""
LATE = 0.5
"""Seconds by which setpoints may be late. After that, real robots are stopped: they have stopped by themselves, or
should have."""

WAITS = "nothing moves until all robots listen: start them, or set `start_without = true` under [ros] in improv.toml"

NOT_READY = "not begun: robots are still waited for; begin once it says `armed`"

Decided = tuple[Run, list[Act]]


def decide(run: Run, event: Event, facts: Facts) -> Decided:
    """The performance after an event, and what to do about it, in this order."""
    then, acts = _RULES[type(event)](run, event, facts)
    if then.misplaced is not None and then.mode != "paused":
        then, acts = replace(then, misplaced=None), [*acts, Tell(preflight.message(None, then.generation))]
    if then.gate and then.mode != "waiting":
        then = replace(then, gate=None)
    if gate.is_ready(run.gate) != gate.is_ready(then.gate):
        acts = [*acts, Tell(gate.message(then.gate, then.generation))]
    return then, acts


def trouble(run: Run, real: bool, late: float, overloaded: bool) -> Event | None:
    """Why real robots that move have to stop at once: setpoints are this late, in seconds, or this machine is
    `overloaded`."""
    if not real or run.mode != "playing":
        return None
    if late > LATE:
        return events.Stalled(late)
    return events.Overloaded() if overloaded else None


def waits(run: Run, facts: Facts) -> list[str]:
    """What has to change before real robots may move."""
    return waits_for(run.score.safety, run.stops, facts.held, facts.away, facts.unseen) if facts.real else []


def _load(run: Run, load: events.Load, facts: Facts) -> Decided:
    score, performed = load.score, run.transport.performed(facts.now)
    moves = facts.real and bool(score.beats or score.open)
    if moves and (line := run.stops.refusal(score.safety, load.stops)):
        return run, [_error(line), Report()]
    goes_on = run.mode in ("playing", "paused") or (run.mode == "ended" and load.entry)
    if load.when == "restart" or not goes_on:
        return run, [PrepareAnew(load), Then(events.Restarted(load))]
    if load.entry:
        at = load.entry["monotonic"] - run.transport.zero
    elif run.mode == "paused":
        at = performed
    else:
        at = run.switch_time(load.when, performed, load.beats_per_bar, facts.over)
    swap = Swap(score, load.generation, load.when, load.beats_per_bar, at, load.entry)
    if run.mode == "paused":
        return _take_over(run, swap, facts)
    return replace(run, next=swap), [Meet(score)]


def _restarted(run: Run, event: events.Restarted, facts: Facts) -> Decided:
    load, before = event.load, run.score.parts
    zero = load.entry["monotonic"] if load.entry else facts.now
    run = replace(
        run.at_scene_of(load.score, 0),
        mode="waiting",
        generation=load.generation,
        restarted=load.generation,
        anyway=load.anyway,
        gate=load.gate,
        next=None,
        transport=Transport(zero, 0.0, 0, load.score.tempo * run.speed),
    )
    if not load.entry:
        return run, [Listen([robot for robot in before if robot in load.score.parts])]
    beat = near(load.entry["beat"])  # another stage may have begun long ago
    run, acts = _play_from(run.at_scene_of(joined(load.score, load.entry), beat), beat, 0.0, facts)
    return run, [Dismiss(), ForgetEdges(), *([Place(beat)] if beat else []), *acts]


def _awaited(run: Run, event: events.Awaited, facts: Facts) -> Decided:
    return run, [Listen()]


def _listened(run: Run, event: events.Listened, facts: Facts) -> Decided:
    # A robot that only has to stop need not wait for the others.
    idle = [robot for robot in event.found if _stands(run.score, robot)]
    acts: list[Act] = [Still(idle)] if idle else []
    if event.waits:
        if event.moving is not None:
            acts += [Still(event.moving), Report()]
        return run, acts
    if event.deaf and run.moves and not run.score.safety.start_without:
        if event.overdue:
            acts += [LookSoon(event.deaf), _warning(WAITS)]
        return run, acts
    if (
        run.gate
        and run.moves
        and not run.gate.is_open(facts.wall)
        and (run.gate.ready or not _displaced(run, facts.places))
    ):
        if run.gate.ready:
            return run, acts
        if event.moving:
            acts.append(Still(event.moving))
        return replace(run, gate=replace(run.gate, ready=True)), [*acts, Report()]
    late = gate.lateness(run.gate, facts.wall)
    run = replace(run, transport=replace(run.transport, zero=facts.now))
    run, more = _play_from(run, 0, 0.0, facts, facts.places)
    told = [_warning(late)] if late and run.mode == "playing" else []
    return run, [*acts, StartMeasuring(), *more, LookSoon(run.score.parts), *told]


def _stands(score: Score, robot: str) -> bool:
    part = score.parts[robot]
    return not part.movement.duration and not any(scene.open for scene in part.scenes)


def _stop(run: Run, event: events.Stop, facts: Facts) -> Decided:
    if run.mode == "waiting" and not run.moves:
        return run, []  # it waits only so that it can stop robots, and none of them would hear it yet
    return _leave(run, "stopped", facts)


def _pause(run: Run, event: events.Pause, facts: Facts) -> Decided:
    if run.mode == "waiting" and run.gate:
        return _stop(run, events.Stop(), facts)  # or it would begin although a person wants robots to stand
    run = replace(run, continues=False)
    return _leave(run, "paused", facts) if run.mode == "playing" else (run, [])


def _resume(run: Run, event: events.Resume, facts: Facts) -> Decided:
    if run.mode == "waiting" and run.gate:
        if not run.gate.ready:
            return run, [_warning(NOT_READY)]
        return replace(run, gate=replace(run.gate, begins=-math.inf)), [Listen()]
    if run.mode != "paused":
        return run, []
    places = {} if event.anyway else facts.places
    return _play_from(run, run.transport.origin, run.transport.performed(facts.now), facts, places)


def _seek(run: Run, event: events.Seek, facts: Facts) -> Decided:
    if run.score is EMPTY or run.mode == "waiting":
        return run, []
    beat = near(min(max(event.beat, 0.0), float(run.begun.beats), LAST_BEAT))
    run = run.at_scene_of(run.begun, beat)
    acts: list[Act] = [Dismiss(), ForgetEdges()]
    if run.mode == "playing":
        places = _places_at(run.score, beat, facts)
        run, more = _play_from(run, beat, run.transport.performed(facts.now), facts, places)
        return run, [*acts, Place(beat), *more]
    return replace(run.left_at(beat), mode="paused"), [*acts, Place(beat), Report()]


def _places_at(score: Score, beat: Exact, facts: Facts) -> Mapping[str, preflight.Standing]:
    """Where robots stand, and where they should be at a beat."""
    ideal = {robot: pose_at(score.parts[robot], beat) for robot in facts.places if robot in score.parts}
    return {robot: preflight.Standing(pose, facts.places[robot].pose) for robot, pose in ideal.items() if pose}


def _speed(run: Run, event: events.Speed, facts: Facts) -> Decided:
    beat = run.beat(facts.now, facts.over)
    run = replace(run, speed=Fraction(str(min(max(event.factor, SLOWEST), FASTEST))))
    if run.mode == "playing":
        return _play_from(run, beat, run.transport.performed(facts.now), facts)
    return replace(run, transport=replace(run.transport, tempo=run.tempo)), [Report()]


def _silence(run: Run, event: events.Silence, facts: Facts) -> Decided:
    muted = frozenset(event.muted)
    stood = {robot: at for robot, at in run.stood.items() if robot in muted or facts.now < at + SEEN}
    then = replace(run, silenced=Silenced(muted, frozenset(event.soloed)), stood=stood)
    changed = [
        robot
        for robot in (run.score.parts if run.mode == "playing" else ())
        if run.is_silent(robot, facts.standing) != then.is_silent(robot, facts.standing)
    ]
    return then, [*([Resend(changed)] if changed else []), Report()]


def _emergency_stop(run: Run, event: events.EmergencyStop, facts: Facts) -> Decided:
    stops = run.stops.heard(event.topic, event.pressed)
    if stops == run.stops:
        return run, []
    run = replace(run, stops=stops)
    told = Tell(stops.message)  # first, so that a person who reads the line and saves is not refused
    if event.pressed:
        run, acts = _stop(run, events.Stop(), facts)
        return run, [told, *acts, _error(f"the emergency stop on {event.topic} is on, so all robots were stopped")]
    return run, [told, Report(), _warning(f"the emergency stop on {event.topic} is off: save to play again")]


def _changed(run: Run, event: events.Changed, facts: Facts) -> Decided:
    must_wait = waits(run, facts)
    if must_wait and run.mode == "playing":
        return _wait(run, facts)
    if not must_wait and run.mode == "paused" and run.continues:
        return _resume(run, events.Resume(), facts)
    return run, []


def _stood(run: Run, event: events.Stood, facts: Facts) -> Decided:
    """Show what still has to be done to robots that are not in their places. They don't begin by themselves."""
    found = preflight.misplaced(facts.places, run.score.safety.preflight)
    if run.misplaced is None or preflight.shown(found) == preflight.shown(run.misplaced):
        return run, []
    there = [] if found else [_warning("all robots are in their places: play again")]
    return replace(run, misplaced=found), [Tell(preflight.message(found, run.generation)), *there]


def _stalled(run: Run, event: events.Stalled, facts: Facts) -> Decided:
    run, acts = _stop(run, events.Stop(), facts)
    line = f"the stage stalled for {event.seconds:.1f} s, so all robots were stopped: save to play again"
    return run, [*acts, _error(line)]


def _overloaded(run: Run, event: events.Overloaded, facts: Facts) -> Decided:
    run, acts = _stop(run, events.Stop(), facts)
    count = len(run.score.parts)
    return run, [
        *acts,
        _error(f"this machine is too slow for {count} robots, so all were stopped: play fewer robots"),
    ]


def _faults(run: Run, event: events.Faults, facts: Facts) -> Decided:
    rules = run.score.safety.faults
    began = [(each.robot, rules.response(each.news.fault)) for each in event.found if isinstance(each.news, FaultBegan)]
    acts: list[Act] = []
    if any(response == "stop" for _, response in began):
        run, acts = _stop(run, events.Stop(), facts)
    for robot in [robot for robot, response in began if response == "stand"]:
        run, more = _stand(run, events.Stand(robot), facts)
        acts += more
    return run, [*acts, TellFaults(event.found)]


def _stand(run: Run, event: events.Stand, facts: Facts) -> Decided:
    robot = event.robot
    if robot in run.stood or robot not in run.score.parts:
        return run, []
    resent: list[Act] = [Resend([robot])] if run.mode == "playing" and not run.is_silent(robot, facts.standing) else []
    return replace(run, stood={**run.stood, robot: facts.now}), [*resent, Report()]


def _too_near(run: Run, event: events.TooNear, facts: Facts) -> Decided:
    keep_apart = run.score.world.keep_apart
    if run.mode != "playing" or keep_apart is None:
        return run, []
    run, acts = _leave(run, "paused", facts)
    robots = dict.fromkeys(robot for near in event.found for robot in near.robots)
    return replace(run, too_near=tuple(robots)), [*acts, _warning(as_line(event.found, keep_apart))]


def _due(run: Run, due: Due, facts: Facts) -> Decided:
    if due.rank == Rank.TAKEOVER:
        assert run.next
        return _take_over(run, run.next, facts)
    beat = run.ends(facts.over)
    assert not isinstance(beat, float)
    if due.rank == Rank.SCENE:
        return _next_scene(run, beat, due.at, facts)
    if run.next and run.next.at == math.inf:
        return _take_over(run, replace(run.next, at=due.at), facts)
    run = replace(run, mode="ended", transport=replace(run.transport, since=due.at, origin=beat))
    # A bump in the last second is reported before the end.
    return run, [Rest(), *([] if facts.real else [Look(run.score.parts)]), Report()]


def _next_scene(run: Run, beat: Exact, at: float, facts: Facts) -> Decided:
    scene, score = run.scene + 1, run.score
    if score.open:  # the beat was not known in advance: count from there
        parts = {
            robot: replace(part, begins=beat, scene=scene, scene_begins=(), entered=facts.poses.get(robot))
            for robot, part in score.parts.items()
        }
        score = replace(score, parts=parts, scene=scene, since=beat)
    run = replace(run, score=score, scene=scene)
    back: list[Act] = [Welcome()] if score.safety.rejoin == "scene" else []
    # It is reported only if its beat was not known in advance.
    return run, [*back, Dismiss(), *_begin(run, score.parts, beat, at, tells=score is not run.begun)]


def _take_over(run: Run, swap: Swap, facts: Facts) -> Decided:
    """Have a score take over. Parts that stay the same are left alone: what is due in them is sent first."""
    old = run.score
    paused = run.mode == "paused"
    beat = run.transport.origin if paused and not swap.entry else swap.beat(run.transport)
    before = Before(old, run.scene, run.is_over(beat, facts.over), None if facts.real else facts.poses)
    score = edited(swap, beat, before)
    begin, leaving = entering(score, before), old.parts.keys() - score.parts.keys()
    goes_on = run.mode == "playing" and score.tempo == old.tempo and not swap.shifts(run.transport)
    replaced = events.Replaced(score, swap.generation, swap.at, beat, begin, leaving, goes_on)
    return replace(run, next=None), [
        Drop({*begin, *leaving} if goes_on else {*old.parts, *score.parts}),
        SendUntil(swap.at),
        Prepare(score, begin, swap.at),
        Then(replaced),
    ]


def _replaced(run: Run, event: events.Replaced, facts: Facts) -> Decided:
    score, begin, old = event.score, event.entering, run.score.parts
    recast = [robot for robot in score.parts if robot in old and old[robot].topic != score.parts[robot].topic]
    run = replace(run, score=score, begun=score, scene=score.scene, generation=event.generation)
    if event.goes_on and not waits(run, facts):
        acts = _begin(run, begin, event.beat, event.at)
        if others := [robot for robot in recast if robot not in begin]:  # their parts go on with other robots
            acts += [
                Resend(others),
                *(_warning(f"{score.parts[each].topic} has the part of {each} now") for each in others),
            ]
    else:
        run, acts = _play_from(run, event.beat, event.at, facts, {} if run.mode == "playing" else facts.places)
    return run, [Dismiss({*begin, *event.leaving}), *acts, LookSoon({*begin, *recast})]


def _play_from(
    run: Run, beat: Exact, performed: float, facts: Facts, places: Mapping[str, preflight.Standing] | None = None
) -> Decided:
    """Play the score from a beat on, starting at this performance time, or as soon as nothing is waited for.

    Robots that stood have to be in their `places`.
    """
    run = replace(run, transport=Transport(run.transport.zero, performed, beat, run.tempo))
    if waits(run, facts):
        return _wait(replace(run, mode="paused"), facts)
    if found := _displaced(run, places or {}):
        run, acts = _leave(replace(run, mode="paused", misplaced=found), "paused", facts)
        return run, [*acts, Tell(preflight.message(found, run.generation)), _error(preflight.refusal(found))]
    if swap := run.next:
        at = run.switch_time(swap.when, performed, swap.beats_per_bar, facts.over)
        run = replace(run, next=replace(swap, at=at))
    run = replace(run, mode="playing", continues=False, too_near=())
    return run, _begin(run, run.score.parts, beat, performed)


def _displaced(run: Run, places: Mapping[str, preflight.Standing]) -> Mapping[str, preflight.Standing]:
    """The robots that have to be in their places first, and are not."""
    return preflight.misplaced(places, run.score.safety.preflight) if run.moves and not run.anyway else {}


def _begin(run: Run, robots: Collection[str], beat: Exact, performed: float, *, tells: bool = True) -> list[Act]:
    """Have robots play their parts of this scene from a beat on, starting at this performance time."""
    told: list[Act] = [Report(run.transport.clock(performed)), ReportSenses(beat, performed)]
    return [Begin(robots, beat, performed), *(told if tells else [])]


def _wait(run: Run, facts: Facts) -> Decided:
    """Pause until nothing has to be waited for. After an emergency stop, somebody has to play again."""
    if run.stops.on:
        line = refused_by(run.stops.on, run.score.safety.stop)
        run, acts = _leave(run, "stopped", facts)
        return run, [*acts, _error(line)]
    first = waits(run, facts)[0]
    run, acts = _leave(run, "paused", facts)
    if first in facts.away:
        what = f"paused until {first} listens again"
    elif first in map(pose_of, facts.unseen):
        what = f"paused: {first} didn't come for {OLDEST} s"
    else:
        what = f"paused: to let robots move, hold {first}"
    return replace(run, continues=True), [*acts, LookLater(), _warning(what)]


def _leave(run: Run, mode: Mode, facts: Facts) -> Decided:
    """Stop all robots here."""
    run = run.left_at(run.beat(facts.now, facts.over))
    following = run.next if mode == "paused" else None
    return replace(run, mode=mode, continues=False, too_near=(), next=following), [Zero(), Report()]


def _error(line: str) -> Tell:
    return Tell({"type": "error", "message": line})


def _warning(line: str) -> Tell:
    return Tell({"type": "warning", "message": line})


_RULES: Mapping[type[Event], Callable[[Run, Any, Facts], Decided]] = {
    events.Load: _load,
    events.Restarted: _restarted,
    events.Awaited: _awaited,
    events.Listened: _listened,
    events.Replaced: _replaced,
    events.Stop: _stop,
    events.Pause: _pause,
    events.Resume: _resume,
    events.Seek: _seek,
    events.Speed: _speed,
    events.Silence: _silence,
    events.EmergencyStop: _emergency_stop,
    events.Changed: _changed,
    events.Stood: _stood,
    events.Stalled: _stalled,
    events.Overloaded: _overloaded,
    events.Faults: _faults,
    events.Stand: _stand,
    events.TooNear: _too_near,
    Due: _due,
}
