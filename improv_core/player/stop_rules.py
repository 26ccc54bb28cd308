"""Rules that make robots stand: stops, pauses, and faults. Pure functions: `(run, event, facts) -> (run, acts)`."""

from __future__ import annotations

import math
from dataclasses import replace

from improv_core.player import events
from improv_core.player.acts import Act, Report, Resend, Tell, TellFaults, Zero
from improv_core.player.events import Facts
from improv_core.player.run import Mode, Run
from improv_core.protocol.commands import Automation
from improv_core.safety.fault_rules import FaultBegan
from improv_core.safety.fault_texts import may_still_move, moved_by_others
from improv_core.safety.separation import as_line

RunAndActs = tuple[Run, list[Act]]


def stop(run: Run, facts: Facts, by: Automation | None = None, *, unasked: bool = False) -> RunAndActs:
    """Stop all robots. If nobody has asked for that, people are offered to continue from there."""
    if run.mode == "waiting" and not run.score.moves:
        return run, []  # it waits only so that it can stop robots, and none of them would hear it yet
    unasked = unasked and (run.unasked or run.mode in ("playing", "paused"))
    run, acts = leave(run, "stopped", facts, by)
    return replace(run, unasked=unasked), [*acts, *_unreached(run, facts)]


def pause(run: Run, facts: Facts) -> RunAndActs:
    if run.mode == "waiting" and (run.gate or facts.real):
        return stop(run, facts)  # or it would begin although a person wants robots to stand
    run = replace(run, continues=False)
    if run.mode != "playing":
        return run, []
    run, acts = leave(run, "paused", facts)
    return run, [*acts, *_unreached(run, facts)]


def emergency_stop(run: Run, event: events.EmergencyStop, facts: Facts) -> RunAndActs:
    stops = run.stops.heard(event.topic, event.pressed)
    if stops == run.stops:
        return run, []
    run = replace(run, stops=stops)
    told = Tell(stops.message)  # first, so that a person who reads the line and saves is not refused
    if event.pressed:
        run, acts = stop(run, facts)
        return run, [told, *acts, error_line(f"the emergency stop on {event.topic} is on, so all robots were stopped")]
    return run, [told, Report(), warning_line(f"the emergency stop on {event.topic} is off: play again")]


def halted(run: Run, event: events.Halted, facts: Facts) -> RunAndActs:
    """Stop, and refuse what people asked the parent for before they could know of this stop, if it was silent."""
    if not event.counts:
        return stop(run, facts, unasked=True)
    run, acts = stop(replace(run, stops=run.stops.counted()), facts, unasked=True)
    return run, [Tell(run.stops.message), *acts]


def stalled(run: Run, event: events.Stalled, facts: Facts) -> RunAndActs:
    run, acts = stop(run, facts, unasked=True)
    line = f"the stage stalled for {event.seconds:.1f} s, so all robots were stopped: play again"
    return run, [*acts, error_line(line)]


def overloaded(run: Run, event: events.Overloaded, facts: Facts) -> RunAndActs:
    run, acts = stop(run, facts, unasked=True)
    count = len(run.score.parts)
    return run, [
        *acts,
        error_line(f"this machine is too slow for {count} robots, so all were stopped: play fewer robots"),
    ]


def faults(run: Run, event: events.Faults, facts: Facts) -> RunAndActs:
    rules = run.score.safety.faults
    began = [(each.robot, rules.response(each.news.fault)) for each in event.found if isinstance(each.news, FaultBegan)]
    acts: list[Act] = []
    if any(response == "stop" for _, response in began):
        run, acts = stop(run, facts, unasked=True)
    for robot in [robot for robot, response in began if response == "stand"]:
        run, more = stand(run, robot, facts)
        acts += more
    return run, [*acts, TellFaults(event.found)]


def stand(run: Run, robot: str, facts: Facts) -> RunAndActs:
    """Have a robot stand because of a fault, until somebody unmutes it."""
    if robot in run.stood or robot not in run.score.parts:
        return run, []
    resent: list[Act] = [Resend([robot])] if run.mode == "playing" and not run.stands(robot, facts.standing) else []
    return replace(run, stood={**run.stood, robot: facts.now}), [*resent, Report()]


def too_near(run: Run, event: events.TooNear, facts: Facts) -> RunAndActs:
    keep_apart = run.score.world.keep_apart
    if run.mode != "playing" or keep_apart is None:
        return run, []
    run, acts = leave(run, "paused", facts)
    robots = tuple(dict.fromkeys(robot for near in event.found for robot in near.robots))
    line = as_line(event.found, keep_apart)
    return replace(run, too_near=robots, startable_by=frozenset()), [
        *acts,
        Tell({"type": "warning", "message": line, "too_near": robots}),
    ]


def leave(run: Run, mode: Mode, facts: Facts, by: Automation | None = None) -> RunAndActs:
    """Stop all robots here. After a stop, only a person, or the automation that caused it, can have them move again."""
    if mode == "stopped":
        run = replace(run, startable_by=run.startable_by & {by})
    run = run.left_at(run.beat(facts.now, facts.over))
    following = run.next if mode == "paused" else None
    if run.clock:
        run = replace(run, clock=replace(run.clock, enters=None, looks=math.inf))
    run = replace(run, mode=mode, continues=False, too_near=(), next=following, unasked=False)
    return run, [Zero(), Report()]


def _unreached(run: Run, facts: Facts) -> list[Act]:
    """Report the robots that may not have received a stop, and those that others can move in spite of it."""
    robots = [robot for robot in run.score.parts if robot in facts.unreached]
    others = {robot: names for robot in run.score.parts if (names := facts.other_publishers.get(robot))}
    lines = [([*others], moved_by_others(others))] if others else []
    lines += [(robots, may_still_move(robots))] if robots else []
    return [
        Tell({"type": "unreached", "generation": run.generation, "robots": named, "message": line})
        for named, line in lines
    ]


def error_line(line: str) -> Tell:
    return Tell({"type": "error", "message": line})


def warning_line(line: str) -> Tell:
    return Tell({"type": "warning", "message": line})
