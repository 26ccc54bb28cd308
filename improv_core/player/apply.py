"""Does the acts that were decided. Nothing here decides anything."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection
from dataclasses import replace
from typing import NoReturn

from improv_core.player import acts, reports
from improv_core.player.acts import Act
from improv_core.player.events import Event
from improv_core.player.sensing import foreseen
from improv_core.player.start_rules import robots_to_home, waits
from improv_core.player.tracks import Tracks
from improv_core.protocol.limits import MEASURED_AT_REST
from improv_core.protocol.messages import Play
from improv_core.protocol.output import BaseCommand
from improv_core.score.motion import STILL
from improv_core.score.movement import Exact
from improv_core.score.path import Paths
from improv_core.score.seeking import known_poses
from improv_core.score.senses import CUE, BuiltIn


def do(act: Act, tracks: Tracks, now: float) -> Event | None:
    """Do one act. Return the event that follows from it, if there is one."""
    match act:
        case acts.Tell(message):
            tracks.tell(message)
        case acts.TellFaults(found):
            for fault in reports.faults(tracks.run, tracks.active_parts.over, found, now, tracks.wall()):
                tracks.tell(fault)
        case acts.Report(at):
            _report(tracks, now if at is None else at, now)
        case acts.ReportSenses(beat, at):
            _report_senses(tracks, beat, at, now)
        case acts.Zero():
            _zero(tracks, now)
        case acts.Still(robots):
            tracks.queue.still(tracks.queue.movers(robots), 0.0)
        case acts.CreatePublishers(score):
            deque(tracks.sink.preload(score), maxlen=0)
            tracks.unsettled = True
        case acts.PrepareRestart(play):
            _prepare_restart(tracks, play, now)
        case acts.Listen(moving):
            return _listen(tracks, moving, now)
        case acts.StartMeasuring():
            tracks.odometry.begin(tracks.run.score.parts, now)
            if tracks.sink.real:
                tracks.faults.restart()
        case acts.Drop(robots):
            tracks.queue.drop(tracks.queue.movers(robots))
        case acts.SendUntil(at):
            tracks.send_due(at)
            tracks.send_repeats(at)
        case acts.Prepare():
            _prepare(tracks, act, now)
        case acts.Dismiss(robots):
            tracks.active_parts.dismiss(robots)
        case acts.ForgetEdges():
            tracks.sensing.forget_announced()
        case acts.Place():
            _place(tracks, act, now)
        case acts.Begin(robots, beat, at):
            tracks.measured_until = math.inf
            tracks.begin(robots, beat, at, now)
        case acts.Resend(robots):
            transport = tracks.run.transport
            for robot in robots:
                tracks.queue.resend(robot, max(transport.performed(now), transport.since))
        case acts.Rest():
            tracks.measured_until = now + MEASURED_AT_REST
        case acts.CheckNow(robots):
            tracks.look(robots)
        case acts.CheckSoon(robots):
            tracks.unseen += robots
        case acts.CheckLater():
            tracks.listeners.wait(now)
        case acts.Then(event):
            return event
        case acts.ReadmitRobots():
            tracks.listeners.readmit()
        case acts.DriveBack(robot, twist):
            tracks.sink.ready([BaseCommand(robot, twist, tracks.run.transport.performed(now))])()
            tracks.faults.tell(robot, twist, now)
            tracks.separation.tell(tracks.run, robot, twist, now)
        case acts.Rejoin(robot):
            tracks.listeners.standing.discard(robot)
        case _:
            _never(act)
    return None


def _never(act: NoReturn) -> NoReturn:
    raise AssertionError(act)


def _report(tracks: Tracks, at: float, now: float) -> None:
    run, over = tracks.run, tracks.active_parts.over
    must_wait = waits(run, tracks.facts(now)) if run.mode in ("paused", "stopped") else []
    poses = reports.whereabouts(tracks.start_poses, tracks.sink.poses())
    tracks.tell(reports.transport(run, over, must_wait, tracks.backend, poses, at, tracks.wall() - (now - at)))


def _report_senses(tracks: Tracks, beat: Exact, at: float, now: float) -> None:
    sensing, score = tracks.sensing, tracks.run.score
    for what in tracks.active_parts.asked:
        is_instant = what.sense == CUE and isinstance(score.parts[what.robot].senses.get(CUE), BuiltIn)
        if not sensing.follows and not is_instant and (value := sensing.value(what, score)) is not None:
            tracks.tell_sensed(what, value, beat, at, now)


def _zero(tracks: Tracks, now: float) -> None:
    performed = tracks.run.transport.performed(now)
    tracks.reached, tracks.measured_until, tracks.moved = now, now + MEASURED_AT_REST, {}
    tracks.queue.stop(tracks.run.score.parts, performed)
    tracks.advance_sink(performed)


def _prepare_restart(tracks: Tracks, play: Play, now: float) -> None:
    score, entry, senses = play.score, play.load.get("entry"), play.load.get("senses")
    old, new = tracks.run.score.parts, score.parts
    performed, both = tracks.run.transport.performed(now), {*old, *new}
    tracks.queue.still(tracks.queue.movers(old.keys() - new.keys()), performed)
    tracks.queue.leave_topics(old, new, performed)
    tracks.sink.prepare(score, "stood" not in play.load)
    tracks.queue.restart(both, performed)
    tracks.paths = Paths()
    tracks.limbs.restart(both, performed)
    if tracks.sink.real:
        tracks.separation.forget()
    else:
        tracks.start_poses = tracks.sink.poses()
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


def _listen(tracks: Tracks, moving: Collection[str] | None, now: float) -> Event:
    found = tracks.listeners.find(now, moving)
    if not found.waits:
        tracks.beginning.compute(tracks.run)
    may_home = robots_to_home(tracks.run, tracks.facts(now), found.waits, found.deaf) if tracks.sink.real else ()
    arrives = tracks.odometry.lacks(tracks.sink.posed())
    return replace(found, waits=tracks.sink.resetting(may_home) or arrives or found.waits)


def _prepare(tracks: Tracks, act: acts.Prepare, now: float) -> None:
    old, new = tracks.run.score.parts, act.score.parts
    tracks.queue.leave_topics(old, new, act.at)
    tracks.paths = Paths()
    tracks.sink.prepare(act.score, False)
    tracks.listeners.begin(act.score, act.entering, now)
    tracks.queue.stop_leaving(old, new, act.at)
    tracks.odometry.set_parts(new, now)


def _place(tracks: Tracks, act: acts.Place, now: float) -> None:
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
