"""Does the acts that were decided. Nothing here decides anything."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import Any

from improv_core.player import acts, reports
from improv_core.player.acts import Act
from improv_core.player.events import Event
from improv_core.player.sensing import foreseen
from improv_core.player.start_rules import robots_to_home, waits
from improv_core.player.tracks import Tracks
from improv_core.protocol.limits import MEASURED_AT_REST
from improv_core.score.motion import STILL
from improv_core.score.path import Paths
from improv_core.score.seeking import known_poses
from improv_core.score.senses import CUE, BuiltIn


def do(act: Act, tracks: Tracks, now: float) -> Event | None:
    """Do one act. Return the event that follows from it, if there is one."""
    return _FUNCTIONS[type(act)](act, tracks, now)


def _tell(act: acts.Tell, tracks: Tracks, now: float) -> None:
    tracks.tell(act.message)


def _report(act: acts.Report, tracks: Tracks, now: float) -> None:
    run, over, at = tracks.run, tracks.active_parts.over, now if act.at is None else act.at
    must_wait = waits(run, tracks.facts(now)) if run.mode in ("paused", "stopped") else []
    wall = tracks.wall() - (now - at)
    poses = reports.whereabouts(tracks.start_poses, tracks.sink.poses())
    tracks.tell(reports.transport(run, over, must_wait, tracks.backend, poses, at, wall))


def _tell_faults(act: acts.TellFaults, tracks: Tracks, now: float) -> None:
    for message in reports.faults(tracks.run, tracks.active_parts.over, act.found, now, tracks.wall()):
        tracks.tell(message)


def _report_senses(act: acts.ReportSenses, tracks: Tracks, now: float) -> None:
    sensing, score = tracks.sensing, tracks.run.score
    for what in tracks.active_parts.asked:
        is_instant = what.sense == CUE and isinstance(score.parts[what.robot].senses.get(CUE), BuiltIn)
        if not sensing.follows and not is_instant and (value := sensing.value(what, score)) is not None:
            tracks.tell_sensed(what, value, act.beat, act.at, now)


def _zero(act: acts.Zero, tracks: Tracks, now: float) -> None:
    performed = tracks.run.transport.performed(now)
    problems = tracks.queue.stop(tracks.run.score.parts, performed)
    tracks.reached, tracks.measured_until, tracks.moved = now, now + MEASURED_AT_REST, {}
    if problems:
        raise problems[0]
    tracks.advance_sink(performed)


def _still(act: acts.Still, tracks: Tracks, now: float) -> None:
    _send_still(tracks, act.robots, 0.0)


def _create_publishers(act: acts.CreatePublishers, tracks: Tracks, now: float) -> None:
    deque(tracks.sink.preload(act.score), maxlen=0)
    tracks.unsettled = True


def _prepare_restart(act: acts.PrepareRestart, tracks: Tracks, now: float) -> None:
    score, entry, senses = act.play.score, act.play.entry, act.play.load.get("senses")
    old, new = tracks.run.score.parts, score.parts
    performed, both = tracks.run.transport.performed(now), {*old, *new}
    _send_still(tracks, old.keys() - new.keys(), performed)
    tracks.queue.leave_topics(old, new, performed)
    tracks.sink.prepare(score, act.play.stood is None)
    tracks.start_poses = tracks.sink.poses()
    tracks.queue.restart(both, performed)
    tracks.paths = Paths()
    tracks.limbs.restart(both, performed)
    if tracks.sink.real:
        tracks.separation.forget()
    else:
        tracks.limbs.learn(new.values(), score.tempo)
    tracks.queue.stop_leaving(old, new, 0.0)
    tracks.advanced, tracks.measured, tracks.measured_until = 0.0, -math.inf, -math.inf
    tracks.odometry.begin(new, now)
    tracks.active_parts.dismiss()
    tracks.sensing.restart(follows=entry is not None or senses is not None, replays=senses is not None)
    tracks.sensing.forget_announced()
    tracks.sensing.announce(map(foreseen, senses or ()))
    tracks.listeners.forget()
    tracks.listeners.begin(score, both, now)
    tracks.listeners.expect(new, now)


def _listen(act: acts.Listen, tracks: Tracks, now: float) -> Event:
    found = tracks.listeners.find(now, act.moving)
    if not found.waits:
        tracks.beginning.compute(tracks.run)
    may_home = robots_to_home(tracks.run, tracks.facts(now), found.waits, found.deaf) if tracks.sink.real else ()
    arrives = tracks.odometry.lacks(tracks.sink.posed())
    return replace(found, waits=tracks.sink.resetting(may_home) or arrives or found.waits)


def _start_measuring(act: acts.StartMeasuring, tracks: Tracks, now: float) -> None:
    tracks.odometry.begin(tracks.run.score.parts, now)
    if tracks.sink.real:
        tracks.faults.restart()


def _drop(act: acts.Drop, tracks: Tracks, now: float) -> None:
    tracks.queue.drop(tracks.queue.movers(act.robots))


def _send_until(act: acts.SendUntil, tracks: Tracks, now: float) -> None:
    tracks.send_due(act.at)
    tracks.send_repeats(act.at)


def _prepare(act: acts.Prepare, tracks: Tracks, now: float) -> None:
    old, new = tracks.run.score.parts, act.score.parts
    tracks.queue.leave_topics(old, new, act.at)
    tracks.paths = Paths()
    tracks.sink.prepare(act.score, False)
    tracks.listeners.begin(act.score, act.entering, now)
    tracks.queue.stop_leaving(old, new, act.at)
    tracks.odometry.set_parts(new, now)


def _dismiss(act: acts.Dismiss, tracks: Tracks, now: float) -> None:
    tracks.active_parts.dismiss(act.robots)


def _forget_edges(act: acts.ForgetEdges, tracks: Tracks, now: float) -> None:
    tracks.sensing.forget_announced()


def _place(act: acts.Place, tracks: Tracks, now: float) -> None:
    real = tracks.sink.real
    parts = {robot: part for robot, part in tracks.run.score.parts.items() if part.odom or not real}
    known = known_poses(parts.values(), act.beat, tracks.paths) if act.poses is None else act.poses
    poses = {robot: known[robot] for robot in parts if robot in known}
    tracks.odometry.place(poses, now)
    if not real:
        tracks.sink.place(poses)
        movers, far = tracks.limbs.place(tracks.run.score.parts, tracks.run.tempo, act.beat)
        for mover in movers:
            told = tracks.limbs.track[mover].tell(STILL, tracks.advanced)
            tracks.sink.send_joints(mover.robot, told, tracks.advanced)
        if far:
            line = f"the joints of {', '.join(far)} don't stand as they do at this beat"
            tracks.tell({"type": "warning", "message": f"{line}: it takes too long to compute that, so jump less far"})


def _begin(act: acts.Begin, tracks: Tracks, now: float) -> None:
    tracks.measured_until = math.inf
    tracks.begin(act.robots, act.beat, act.at, now)


def _resend(act: acts.Resend, tracks: Tracks, now: float) -> None:
    transport = tracks.run.transport
    for robot in act.robots:
        tracks.queue.resend(robot, max(transport.performed(now), transport.since))


def _rest(act: acts.Rest, tracks: Tracks, now: float) -> None:
    tracks.measured_until = now + MEASURED_AT_REST


def _check_now(act: acts.CheckNow, tracks: Tracks, now: float) -> None:
    tracks.look(act.robots)


def _check_soon(act: acts.CheckSoon, tracks: Tracks, now: float) -> None:
    tracks.unseen += act.robots


def _check_later(act: acts.CheckLater, tracks: Tracks, now: float) -> None:
    tracks.listeners.wait(now)


def _then(act: acts.Then, tracks: Tracks, now: float) -> Event:
    return act.event


def _readmit_robots(act: acts.ReadmitRobots, tracks: Tracks, now: float) -> None:
    tracks.listeners.readmit()


def _drive_back(act: acts.DriveBack, tracks: Tracks, now: float) -> None:
    tracks.sink.send(act.robot, act.twist, tracks.run.transport.performed(now))
    tracks.faults.tell(act.robot, act.twist, now)
    tracks.separation.tell(tracks.run, act.robot, act.twist, now)


def _rejoin(act: acts.Rejoin, tracks: Tracks, now: float) -> None:
    tracks.listeners.standing.discard(act.robot)


def _send_still(tracks: Tracks, robots: Collection[str], performed: float) -> None:
    tracks.queue.still(tracks.queue.movers(robots), performed)


_FUNCTIONS: Mapping[type[Act], Callable[[Any, Tracks, float], Event | None]] = {
    acts.Tell: _tell,
    acts.TellFaults: _tell_faults,
    acts.Report: _report,
    acts.ReportSenses: _report_senses,
    acts.Zero: _zero,
    acts.Still: _still,
    acts.CreatePublishers: _create_publishers,
    acts.PrepareRestart: _prepare_restart,
    acts.Listen: _listen,
    acts.StartMeasuring: _start_measuring,
    acts.Drop: _drop,
    acts.SendUntil: _send_until,
    acts.Prepare: _prepare,
    acts.Dismiss: _dismiss,
    acts.ForgetEdges: _forget_edges,
    acts.Place: _place,
    acts.Begin: _begin,
    acts.Resend: _resend,
    acts.Rest: _rest,
    acts.CheckNow: _check_now,
    acts.CheckSoon: _check_soon,
    acts.CheckLater: _check_later,
    acts.Then: _then,
    acts.ReadmitRobots: _readmit_robots,
    acts.DriveBack: _drive_back,
    acts.Rejoin: _rejoin,
}
