"""The only loop of a performance: it decides what follows from an event, does that, and sends what is due.

It never reads a clock; callers pass the time in. `now` is the clock's time in seconds. `performed` and `at` are
performance times: seconds since the latest restart, including pauses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from improv_core.player import agenda, events, reports
from improv_core.player.agenda import Rank
from improv_core.player.apply import do
from improv_core.player.decide import decide, trouble
from improv_core.player.events import AHEAD_OF_DUE, Event
from improv_core.player.returning import HomeStep, Sightings
from improv_core.player.run import Run
from improv_core.player.sensing import Foreseen
from improv_core.player.start_gate import time_left
from improv_core.player.tracks import Tracks
from improv_core.protocol.commands import Cue, Force, OscSense
from improv_core.protocol.messages import FromStage, Play, Poses
from improv_core.protocol.output import Edge, RawJoints, RawPose, Sink, StopButton
from improv_core.safety.fault_monitor import RobotNews
from improv_core.score.peer_clock import Anchor
from improv_core.score.senses import Key, RobotSense

LOOK_AGAIN = 0.01
"""Seconds between two checks for listeners before beat 0, and between two of robots that still move after the end."""
LOOK_WHILE_ARMED = 0.1
"""Seconds between checks of the wall clock while beat 0 waits for a person, or for a time that is not yet near."""


VITALS_PERIOD = 1.0
"""Seconds between two reports of the condition of real robots."""


class Player:
    """Plays one score at a time on a sink, and reports what it does in messages (see docs/protocol.md).

    It has a run, which only its loop replaces, and the tracks that play the run.
    """

    def __init__(self, sink: Sink, tell: Callable[[FromStage], None], wall: Callable[[], float]) -> None:
        self._sink = sink
        self._tracks = Tracks(sink, tell, wall)
        self._vitals_due = -math.inf

    @property
    def run(self) -> Run:
        """The latest decision about the performance."""
        return self._tracks.run

    @property
    def reached(self) -> float:
        """The time on the clock up to which everything has been sent."""
        return self._tracks.reached

    @property
    def is_exact(self) -> bool:
        """True while the next thing due must be sent at its exact time. Repeats may be a little late."""
        return self._tracks.next_due().rank != Rank.REPEATS

    @property
    def sends(self) -> bool:
        """True while something is left to send, robots are awaited, or simulated ones still move."""
        return self.run.mode == "waiting" or self._tracks.next_due().at < math.inf or _still_move(self._tracks)

    def deadline(self, now: float) -> float:
        """The time on the clock at which `advance` must be called next; infinite if nothing is left to do."""
        if self.run.mode == "waiting":
            if self.run.is_due:
                return now
            left = time_left(gate, now, self._tracks.wall()) if (gate := self.run.gate) else 0.0
            return now + (min(LOOK_WHILE_ARMED, left) if left > 0 else LOOK_AGAIN)
        due = self._tracks.next_due().at
        if due < math.inf:
            separation = self._tracks.separation
            at = min(self.run.transport.clock(due), separation.deadline(self.run), separation.due, self._returns_due)
            return min(at, now + self._sink.period) if self._sink.period else at
        if self._looks_while_paused:
            return max(min(self._tracks.listeners.next_look, self._tracks.faults.next_look), now)
        return now + (self._sink.period or LOOK_AGAIN) if _still_move(self._tracks) else math.inf

    def prepare(self) -> None:
        """Prepare the next changes of velocity, so that they leave at once when they are due."""
        self._tracks.queue.prepare()

    def advance(self, now: float, late: float = 0.0) -> None:
        """Do what is due, `late` seconds after the deadline."""
        if self.run.mode == "waiting":
            self._decide(events.Awaited(late), now)
        else:
            self._tracks.unsettled = True
            is_seen = now < self._tracks.separation.deadline(self.run)
            self._decide(None if is_seen else events.Changed(), now)

    def take(self, event: Event, now: float, late: float = 0.0) -> None:
        """Decide and do what follows from an event. If other stages did it `late` seconds ago, this one continues from
        where they are now."""
        if isinstance(event, Anchor) or (isinstance(event, dict) and event["type"] not in AHEAD_OF_DUE):
            self._catch_up(now)
        if isinstance(event, Play):
            self._tracks.backend = event.load["backend"] or self._tracks.backend
            self._tracks.informed = now if "entry" in event.load else self._tracks.informed
        self._decide(event, now, late)

    def sense(self, edge: Edge, now: float) -> None:
        """Take an edge. An emergency stop stops all, a released deadman button pauses, and robots react to senses."""
        match edge.what:
            case RobotSense() as what:
                self._catch_up(max(min(edge.at, now), self.reached))
                self._tracks.sense(what, edge.value, edge.at, now)
            case Key() as key:
                self._catch_up(now)
                self._react(self._tracks.sensing.hold_key(key, bool(edge.value), self.run.score), now)
            case StopButton(topic):
                self.take(events.EmergencyStop(topic, bool(edge.value)), now)
            case button:
                self._tracks.sensing.hold(button, edge.value)
                self.take(events.Changed(), now)

    def hear(self, message: Cue | OscSense | Force, now: float) -> None:
        """Take a message about senses: their robots react."""
        if message["type"] == "force" and self._sink.real:
            line = f"{message['robot']} is a real robot: its senses can't be forced"
            self._tracks.tell({"type": "warning", "message": line})
            return
        self._catch_up(now)
        self._react(self._tracks.sensing.hear(message, self.run.score), now)

    def foresee(self, edge: Foreseen, now: float) -> None:
        """Take an edge at its beat, as reported by the stage that leads."""
        self._catch_up(now)
        self._tracks.informed = now
        self._tracks.sensing.announce([edge])
        self._catch_up(now)

    def measure(self, poses: Iterable[RawPose], now: float) -> None:
        """Take measured poses, and report where robots were and where they ideally would have been. If real robots are
        too near to each other, everything pauses."""
        self._tracks.measure(poses, now)
        waits_for_pose = self.run.mode == "paused" and self.run.continues and self.run.score.safety.sight
        if waits_for_pose or self.run.misplaced is not None:
            self.take(events.Changed(), now)
        if event := self._tracks.separation.look(self.run, now):
            self.take(event, now)

    def measure_joints(self, joints: RawJoints, now: float) -> None:
        """Report where joints of a real robot were."""
        run, tracks, part = self.run, self._tracks, self.run.score.parts.get(joints.robot)
        if part and part.profile.body and now < tracks.measured_until:
            wall = tracks.wall() - (now - joints.at)
            tracks.tell(reports.joints(run, tracks.active_parts.over, joints, part.profile.body, wall))

    def whereabouts(self) -> Poses:
        """The poses of simulated robots at beat 0 and now; empty for real robots."""
        return reports.whereabouts(self._tracks.start_poses, self._sink.poses())

    def _catch_up(self, now: float) -> None:
        """Send what is due before something changes, so robots don't miss it."""
        if self.run.mode == "playing":
            self.advance(now)

    def _react(self, senses: Iterable[RobotSense], now: float) -> None:
        for what in senses:
            self._tracks.react(what, now, now)

    def _decide(self, event: Event | None, now: float, late: float = 0.0) -> None:
        """Decide and do what follows from an event, and then everything that is due. This is the only loop: no act and
        no decision starts another."""
        tracks = self._tracks
        while event or (event := self._send_due(now)):
            tracks.queue.forget_prepared()  # whatever is decided
            tracks.run, todo = decide(tracks.run, event, tracks.facts(now, event, late))
            event, late = None, 0.0
            for act in todo:
                event = do(act, tracks, now) or event
        if tracks.unseen:
            robots, tracks.unseen = tracks.unseen, []
            tracks.look([robot for robot in robots if robot in tracks.run.score.parts])

    def _send_due(self, now: float) -> Event | None:
        """Send everything that is due and has been decided. Return the next event to decide."""
        tracks, run = self._tracks, self._tracks.run
        if not tracks.unsettled:
            return None
        due = tracks.next_due().at
        late = run.transport.performed(now) - max(due, run.transport.performed(tracks.informed))
        overloaded = tracks.queue.repeats.hopeless
        if reason := trouble(run, self._sink.real, late, overloaded):
            tracks.unsettled = False
            return reason
        tracks.reached = now
        performed = agenda.performed(run, now, due)
        if decision := tracks.send_due(performed):
            if decision.rank != Rank.TAKEOVER:  # a takeover sends the rest itself
                tracks.send_repeats(decision.last_before(Rank.CHANGES))
            return decision
        tracks.send_repeats(performed)
        tracks.unsettled = False
        if self._sink.real and (line := tracks.queue.repeats.news()):
            tracks.tell({"type": "warning", "message": line})
        if now >= tracks.separation.due and (event := tracks.separation.look(self.run, now)):
            return event
        if now >= self._returns_due:
            return events.Returning(self._steps(now))
        return self._look_around(now)

    @property
    def _returns_due(self) -> float:
        """The time on the clock of the next check of robots that drive back to their parts."""
        return self._tracks.returns.due(self.run, self._tracks.listeners.returning)

    def _steps(self, now: float) -> list[HomeStep]:
        """Return the next steps of robots that drive back to their parts."""
        run, tracks, over = self.run, self._tracks, self._tracks.active_parts.over
        ready = tracks.listeners.returning - tracks.listeners.away
        back = [robot for robot in run.score.parts if robot in ready and not run.stands(robot, ())]
        ideal = {robot: each.ideal for robot, each in tracks.odometry.places(now).items()}
        doubtful = [robot for robot in back if tracks.odometry.is_doubtful(robot, now)]
        ends = run.transport.clock(run.transport.end(run.ends(over)))
        seen = Sightings(now, run.beat(now, over), tracks.separation.poses(run, now), ideal, doubtful, ends)
        return tracks.returns.look(run, back, seen)

    def _look_around(self, now: float) -> Event | None:
        """Check a few robots for faults and, if that is due, for listeners."""
        tracks = self._tracks
        if not (self.run.mode == "playing" or self._looks_while_paused):
            return None
        if found := self._find_faults(now):
            return events.Faults(found)
        if now < tracks.listeners.next_look:
            return None
        waits = self.run.mode == "paused" and self.run.continues
        standing, done = tracks.listeners.look_around(self.run.score, now, waits)
        tracks.queue.silence(standing)
        if done:
            tracks.tell_news()
            for line in tracks.separation.lines(self.run, tracks.odometry, now):
                tracks.tell({"type": "warning", "message": line})
        return events.Changed()

    def _find_faults(self, now: float) -> list[RobotNews]:
        """Return news about faults of real robots, if a check is due. Once a second, report the condition of all."""
        run, tracks = self.run, self._tracks
        if not self._sink.real or not tracks.faults.is_due(run.score, now):
            return []
        noticed = self._sink.noticed()
        if line := tracks.faults.simulation(noticed, run.score):
            tracks.tell({"type": "warning", "message": line})
        if now >= self._vitals_due:
            self._vitals_due = now + VITALS_PERIOD
            posed = {robot: run.transport.performed(at) for robot, at in tracks.faults.posed.items()}
            away = tracks.listeners.standing, tracks.returns.driving
            tracks.tell(reports.vitals(run, posed, noticed.batteries, *away))
            for line in tracks.faults.low_batteries(noticed.batteries):
                tracks.tell({"type": "warning", "message": line})
        gone, back = tracks.listeners.gone, tracks.listeners.returning
        return list(tracks.faults.look_around(run.score, gone, noticed, now, back))

    @property
    def _looks_while_paused(self) -> bool:
        """True while real robots are paused: somebody may carry them away, or they may get lost."""
        return self.run.mode == "paused" and self._sink.real


def _still_move(tracks: Tracks) -> bool:
    """Return whether simulated robots still move after a stop, or no report has shown yet that they stand."""
    if tracks.sink.real:
        return False
    return (tracks.moved is not None and bool(tracks.odometry.robots)) or tracks.sink.coasting()
