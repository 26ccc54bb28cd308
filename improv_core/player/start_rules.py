"""Rules for when robots may begin or continue: listeners, gates, interlocks, and the places where they should stand.

Pure rules of the player: `(run, event, facts) -> (run, acts)`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace
from fractions import Fraction

from improv_core.player import events, start_gate
from improv_core.player.acts import (
    Act,
    Begin,
    CheckLater,
    CheckSoon,
    Dismiss,
    ForgetEdges,
    Listen,
    Place,
    Report,
    ReportSenses,
    StartMeasuring,
    Still,
    Tell,
    Zero,
)
from improv_core.player.events import Facts
from improv_core.player.run import ONE, Run
from improv_core.player.start_gate import Gate
from improv_core.player.stop_rules import RunAndActs, error_line, leave, warning_line
from improv_core.protocol.commands import Automation
from improv_core.protocol.play_again import NOT_READY, STOPPED
from improv_core.safety import preflight
from improv_core.safety.interlocks import pose_of, refused_by, waits_for
from improv_core.score.following import OLDEST
from improv_core.score.movement import Exact, near
from improv_core.score.outside_clock import followed, waiting_line
from improv_core.score.score import Score
from improv_core.score.takeover import Takeover, joined
from improv_core.score.transport import Transport

FEW, LEAD = 10, 0.000_02
"""Beat 0 of more than a few real robots comes this many seconds later for each other one: so long it takes until their
first commands are ready. Otherwise their first movement would be shorter than it should be."""
OPENS = 0.05
"""Seconds before robots come in with a clock from which on that moment stays as it is."""
WAITS = "nothing moves until all robots listen: start them, or set `start_without = true` under [ros] in improv.toml"

QUIET = 10.0
"""Seconds after a pause for an unseen robot without lines about others: poses may be late again and again."""


def restarted(run: Run, event: events.Restarted, facts: Facts) -> RunAndActs:
    play, load, before = event.play, event.play.load, run.score.parts
    entry = load.get("entry")
    zero = entry["monotonic"] if entry else facts.now
    run = replace(
        run.at_scene_of(play.score, 0),
        mode="waiting",
        generation=load["generation"],
        restarted=load["generation"],
        anyway=load.get("anyway", False),
        gate=Gate(load["arming"].get("begins", math.inf), shared="here" in load) if "arming" in load else None,
        is_due=False,
        next=None,
    )
    run = in_time(run, entry, facts)
    if "stood" in load:
        return _standing(run, play.score, load["stood"], facts)
    if run.clock and run.clock.is_music:
        clock = replace(run.clock, ours=0.0, theirs=0.0, slope=Fraction(0), warned=False)
        run = replace(run, clock=clock, gate=run.gate or (Gate(at_bar=True) if run.score.moves else None))
    elif play.score.count_in and run.score.moves and not entry:
        run = replace(run, gate=start_gate.counted(run.gate, play.score.bar or play.beats_per_bar))
    run = replace(run, transport=Transport(zero, 0.0, 0, run.tempo))
    if not entry:
        return run, [Listen([robot for robot in before if robot in play.score.parts])]
    beat = near(entry["beat"])  # another stage may have begun long ago
    run, acts = play_from(run.at_scene_of(joined(play.score, entry), beat), beat, 0.0, facts)
    return run, [Dismiss(), ForgetEdges(), *([Place(beat)] if beat else []), *acts]


def _standing(run: Run, score: Score, stood: Takeover, facts: Facts) -> RunAndActs:
    """Stand where another stage stood when it died. Nobody has asked for that, so only a person has robots continue."""
    beat = near(stood["beat"])
    run = replace(run.at_scene_of(joined(score, stood), beat), mode="stopped", unasked=True, startable_by=frozenset())
    run = replace(run, transport=Transport(facts.now, 0.0, beat, run.tempo))
    return run, [Zero(), Dismiss(), ForgetEdges(), Place(beat), Report()]


def awaited(run: Run, event: events.Awaited, facts: Facts) -> RunAndActs:
    return _begin(run, facts) if run.is_due else (run, [Listen()])


def listened(run: Run, event: events.Listened, facts: Facts) -> RunAndActs:
    # A robot that only has to stop need not wait for the others.
    idle = [robot for robot in event.found if _stands(run.score, robot)]
    acts: list[Act] = [Still(idle)] if idle else []
    if event.waits:
        if event.moving is not None:
            acts += [Still(event.moving), Report()]
        return run, acts
    if event.deaf and run.score.moves and not run.score.safety.start_without:
        if event.overdue:
            acts += [CheckSoon(event.deaf), warning_line(WAITS)]
        return run, acts
    if (
        run.gate
        and run.score.moves
        and run.gate.late(facts.now, facts.wall) < 0
        and (run.gate.ready or not _displaced(run, facts.places))
    ):
        if run.gate.ready:
            return run, acts
        if event.moving:
            acts.append(Still(event.moving))
        if run.clock and run.gate.at_bar and run.gate.begins == math.inf:
            acts.append(warning_line(f"the dance begins at the next bar of {run.clock.name}, once it is heard"))
        ready = start_gate.made_ready(run.gate, facts.now, facts.wall, run.beat_period)
        return replace(run, gate=ready), [*acts, Report()]
    # Checking robots takes time: 0.2 s while the network finds them, 20 ms for a hundred. Beat 0 comes after it.
    return replace(run, is_due=True), acts


def _begin(run: Run, facts: Facts) -> RunAndActs:
    """Begin: beat 0 is now, or for many real robots, once their first commands are ready."""
    zero, passed, late = facts.now + facts.real * LEAD * max(len(run.score.parts) - FEW, 0), 0.0, ""
    if gate := run.gate:
        zero, passed = start_gate.beat_zero(gate, facts.now), start_gate.passed(gate, facts.now)
        late = start_gate.lateness(gate, facts.now, facts.wall)
    run = replace(run, transport=replace(run.transport, zero=zero))
    run, acts = play_from(run, run.later(0, passed), 0.0, facts, facts.places)
    told = [warning_line(late)] if late and run.mode == "playing" else []
    return run, [StartMeasuring(), *acts, CheckSoon(run.score.parts), *told]


def resume(run: Run, facts: Facts, by: Automation | None = None, *, anyway: bool = False) -> RunAndActs:
    """Begin an armed score, or continue a paused one, as soon as no condition is left. Robots must be in their places,
    except with `anyway`."""
    if run.mode == "waiting" and run.gate:
        if not run.gate.ready:
            return run, [warning_line(NOT_READY)]
        return replace(run, gate=_opened(run, run.gate, facts)), [Listen()]
    if run.mode != "paused":
        return run, []
    if not run.may_start(by):
        return run, [warning_line(STOPPED)]
    run = run.started(by)
    if comes_in(run) and not anyway:
        return coming_in(replace(run, continues=True), facts), [Report()]
    places = {} if anyway else facts.places
    beat = run.later(run.transport.origin, facts.late)
    return play_from(run, beat, run.transport.performed(facts.now), facts, places)


def changed(run: Run, event: events.Changed, facts: Facts) -> RunAndActs:
    run, told = _look_again(run, facts)
    must_wait = waits(run, facts)
    if must_wait and run.mode == "playing":
        return _wait(run, facts)
    if not must_wait and run.mode == "paused" and run.continues:
        run, acts = play_from(run, run.transport.origin, run.transport.performed(facts.now), facts, facts.places)
        return run, [*told, *acts]
    return run, told


def comes_in(run: Run) -> bool:
    """Return whether a clock of music runs, so that robots come in at their beat of a bar, and not at any moment."""
    clock = run.clock
    return clock is not None and clock.is_music and clock.rate > 0 and not clock.silent


def coming_in(run: Run, facts: Facts) -> Run:
    """Plan to end a pause when a clock of music is at the beat of the performance, as a musician comes in again."""
    clock, performed = run.clock, run.transport.performed(facts.now)
    assert clock
    if clock.enters is not None and abs(clock.enters - performed) < OPENS:
        return run  # it is about to
    left = clock.until(float(run.transport.origin), run.slope, run.bar, facts.now)
    enters = performed + left if left < math.inf else None
    return replace(run, clock=replace(clock, enters=enters, looks=math.inf if enters is None else enters))


def play_from(
    run: Run, beat: Exact, performed: float, facts: Facts, places: Mapping[str, preflight.Standing] | None = None
) -> RunAndActs:
    """Play the score from a beat on, starting at this performance time, or as soon as no condition is left.

    Robots that stood have to be in their `places`.
    """
    run = run.aligned(beat, run.transport.clock(performed))
    run = replace(run, transport=Transport(run.transport.zero, performed, beat, run.tempo))
    if waits(run, facts):
        return _wait(replace(run, mode="paused"), facts)
    if found := _displaced(run, places or {}):
        run, acts = leave(replace(run, mode="paused", misplaced=found), "paused", facts)
        return run, [*acts, Tell(preflight.message(found, run.generation)), error_line(preflight.refusal(found))]
    return keep_playing(replace(run, mode="playing", continues=False, too_near=()), beat, performed, facts)


def keep_playing(run: Run, beat: Exact, performed: float, facts: Facts) -> RunAndActs:
    """Keep playing from a beat, at the tempo of the run, starting at this performance time."""
    run = replace(run, transport=Transport(run.transport.zero, performed, beat, run.tempo))
    if swap := run.next:
        at = run.switch_time(swap.when, performed, swap.beats_per_bar, facts.over)
        run = replace(run, next=replace(swap, at=at))
    return run, begin_parts(run, run.score.parts, beat, performed)


def begin_parts(run: Run, robots: Collection[str], beat: Exact, performed: float, *, tells: bool = True) -> list[Act]:
    """Have robots play their parts of this scene from a beat on, starting at this performance time."""
    told: list[Act] = [Report(run.transport.clock(performed)), ReportSenses(beat, performed)]
    return [Begin(robots, beat, performed), *(told if tells else [])]


def waits(run: Run, facts: Facts) -> list[str]:
    """Return the conditions that robots wait for before they move: those of real ones, and a clock that stands."""
    clock = [run.clock.name] if run.clock and run.clock.stands else []
    if not facts.real:
        return clock
    return waits_for(run.score.safety, run.stops, facts.held, facts.away, facts.unseen) or clock


def robots_to_home(run: Run, facts: Facts, waits_for_listeners: bool, deaf: Collection[str]) -> list[str]:
    """Return the real robots whose joints may be brought to their starts before beat 0: those that might move there."""
    if run.mode != "waiting" or waits_for_listeners or waits(run, facts):
        return []
    if deaf and not run.score.safety.start_without:
        return []
    return [robot for robot in run.score.parts if robot not in deaf and not run.stands(robot, facts.standing)]


def _look_again(run: Run, facts: Facts) -> RunAndActs:
    """Report the robots that are not in their places yet. They don't begin by themselves."""
    found = preflight.misplaced(facts.places, run.score.safety.preflight)
    if run.misplaced is None or preflight.shown(found) == preflight.shown(run.misplaced):
        return run, []
    there = [] if found else [warning_line("all robots are in their places: play again")]
    return replace(run, misplaced=found), [Tell(preflight.message(found, run.generation)), *there]


def _wait(run: Run, facts: Facts) -> RunAndActs:
    """Pause until no condition is left. After an emergency stop, somebody has to play again."""
    if run.stops.on:
        line = refused_by(run.stops.on, run.score.safety.stop)
        run, acts = leave(run, "stopped", facts)
        return run, [*acts, error_line(line)] if run.score.moves else acts
    first = waits(run, facts)[0]
    run, acts = leave(run, "paused", facts)
    if first in facts.away:
        what = f"paused until {first} listens again"
    elif run.clock and first == run.clock.name:
        what = waiting_line(run.clock)
    elif first in map(pose_of, facts.unseen):
        what = "" if facts.now < run.blind + QUIET else f"paused: {first} didn't come for {OLDEST} s"
        run = replace(run, blind=facts.now)
    else:
        what = f"paused: to let robots move, hold {first}"
    return replace(run, continues=True), [*acts, CheckLater(), *([warning_line(what)] if what else [])]


def in_time(run: Run, entry: Takeover | None, facts: Facts) -> Run:
    """Return the run with the clock that its score follows, or with the pace and the delay of the stage that leads."""
    if entry:
        pace = Fraction(str(entry["pace"])) if "pace" in entry else ONE
        return replace(run, clock=None, pace=pace, behind=entry.get("behind", 0.0))
    clock = followed(run.clock, run.score.clock, facts.real) if run.score.clock else None
    pace = run.pace_at(clock.rate) if clock and clock.rate else ONE
    return replace(run, clock=clock, pace=pace, behind=0.0)


def _opened(run: Run, closed: Gate, facts: Facts) -> Gate:
    """Return the gate after a person opens it: at the next bar of a clock that runs, after a count, or at once."""
    left = run.clock.until(0, run.slope, run.bar, facts.now) if run.clock else math.inf
    if left < math.inf:
        return replace(closed, begins=facts.wall + left, opened=facts.now + left, at_bar=True, count=0)
    if closed.count:
        counts = start_gate.counts(closed, facts.now, facts.wall)
        return closed if counts else start_gate.counting(closed, facts.now, facts.wall, run.beat_period)
    return replace(closed, begins=-math.inf, at_bar=False, opened=facts.now)


def _displaced(run: Run, places: Mapping[str, preflight.Standing]) -> Mapping[str, preflight.Standing]:
    """Return the robots that have to be in their places first, and are not."""
    must_be_there = places and run.score.moves and not run.anyway
    return preflight.misplaced(places, run.score.safety.preflight) if must_be_there else {}


def _stands(score: Score, robot: str) -> bool:
    part = score.parts[robot]
    return not part.movement.duration and not any(scene.open for scene in part.scenes)
