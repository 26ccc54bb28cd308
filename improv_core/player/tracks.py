"""The setpoints and other messages to robots: fast, mutable, and without decisions. Those are in `decide.py`.

It never reads a clock. `performed` and `at` are performance times: seconds since the latest restart, including pauses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import partial

from improv_core.player import reports
from improv_core.player.active_parts import ActiveParts, ComputedBeginning
from improv_core.player.agenda import NEVER, Due, Rank, next_decision, next_edges
from improv_core.player.events import Event, Facts
from improv_core.player.limb_tracks import JointCommands, Limbs
from improv_core.player.open_part import TooManyChangesError
from improv_core.player.returning import Returns
from improv_core.player.run import EMPTY, Run
from improv_core.player.sensing import Sensing
from improv_core.player.separation_monitor import SeparationMonitor
from improv_core.player.setpoint_queue import MoverCommand, SetpointQueue, zeros
from improv_core.player.subscribers import Listeners
from improv_core.protocol.messages import SIMULATED, FromStage, Play
from improv_core.protocol.output import BaseCommand, RawPose, Sink, try_all
from improv_core.safety.fault_monitor import FaultMonitor
from improv_core.safety.odometry import Odometry
from improv_core.score.motion import Pose, Twist
from improv_core.score.movement import Duration, Exact
from improv_core.score.path import Paths
from improv_core.score.performance import Mover
from improv_core.score.score import twist
from improv_core.score.senses import CUE, RobotSense

MEASURE_PERIOD = 0.05
"""Seconds between two measurements of a simulated robot."""


class Tracks:
    """Each robot's track: its setpoints and, if senses decide what it does, its open part. They go to one sink."""

    def __init__(self, sink: Sink, tell: Callable[[FromStage], None], wall: Callable[[], float]) -> None:
        self.sink = sink
        self.tell = tell
        self.run = Run(startable_by=frozenset())  # until a person has played something
        """The latest decision. Only the player's loop replaces it."""
        self.backend = sink.name
        self.start_poses: Mapping[str, Pose] = {}
        self.joints = JointCommands(
            lambda robot, joints, at: sink.send_joints(
                robot, joints, at, self.run.simulated_pace, self.queue.next_of_limbs(robot, at)
            )
        )
        self.queue = SetpointQueue(self._ready, self._stands, self._withhold)
        self.sensing = Sensing()
        self.active_parts = ActiveParts(lambda what: self.sensing.value(what, self.run.score))
        self.limbs = Limbs()
        self.paths = Paths()
        self.listeners = Listeners(sink)
        self.odometry = Odometry()
        self.faults = FaultMonitor()
        self.separation = SeparationMonitor(sink)
        self.returns = Returns()
        self.reached = 0.0
        """The time on the clock up to which everything has been sent."""
        self.informed = -math.inf
        """The time on the clock of the latest news about something that was perhaps due before: that is no stall."""
        self.advanced = 0.0
        """The performance time up to which the sink has been advanced."""
        self.measured = -math.inf
        """The number of the period in which simulated robots were measured last."""
        self.measured_until = -math.inf
        """The time on the clock until which real robots are reported: those that were stopped have come to rest."""
        self.moved: Mapping[str, Pose] | None = None
        """The latest reported poses of simulated robots; None if two reports agree: the robots have come to rest."""
        self.unsettled = False
        """True if something may be due that has not been sent."""
        self.unseen: list[str] = []
        """Robots to check once everything that is due has been sent."""
        self._known: tuple[Run, Duration, Due] = self.run, 0, NEVER  # a run, and the next thing to decide in it
        self.beginning = ComputedBeginning(self.run)
        self.wall = wall

    # Sending in time

    def next_due(self) -> Due:
        changes, repeats = self.queue.due, self.queue.repeats.due
        due = Due(changes, Rank.CHANGES) if changes <= repeats else Due(repeats, Rank.REPEATS)
        if self.sensing.announced is not None:
            due = min(due, next_edges(self.run, self.sensing.announced))
        return min(due, self._next_decision)

    @property
    def _next_decision(self) -> Due:
        """The next thing to decide. It is read at every setpoint, and seldom changes."""
        run, over, due = self._known
        if run is not self.run or over is not self.active_parts.over:
            due = next_decision(self.run, self.active_parts.over)
            self._known = self.run, self.active_parts.over, due
        return due

    def send_due(self, asked: float) -> Due | None:
        """Send every change until the performance time `asked`, including those that sensing causes. If something has
        to be decided first, return that instead."""
        while True:
            decision = self._next_decision
            # A sense may just have ended everything before what is due now: zeros come first.
            ends = self.active_parts.asked and decision.rank == Rank.END
            until = asked if ends else min(asked, decision.last_before(Rank.CHANGES))
            edges_at, changes_at = next_edges(self.run, self.sensing.announced).at, self.queue.due
            first = min(edges_at, changes_at)
            if self.active_parts.asked and self._feel(min(first, until)):
                continue
            if first > until:
                return decision if decision.is_due(asked) else None
            if edges_at <= changes_at:
                self._take_announced(first)
            else:
                self._send_changes(first if self.active_parts.asked else until)

    def _send_changes(self, until: float) -> None:
        """Send every change until then, and only then decide what follows."""
        performed: list[tuple[Mover, float]] = []

        def perform(mover: Mover, at: float) -> None:
            performed.append((mover, at))
            beat = self.active_parts.open[mover].due
            assert not isinstance(beat, float)
            self._perform(mover, beat, at)

        with self.joints.together():  # they are sent once it is planned when they change next
            try:
                self.queue.send_changes(until, self.run.score.parts, perform)
            finally:
                for mover, at in performed:
                    self._plan(mover, at)

    def send_repeats(self, performed: float) -> None:
        """Send the repeats of one slot, so that a change never waits for more, and advance the sink."""
        self.queue.send_repeats(performed)
        self.advance_sink(performed)

    def advance_sink(self, performed: float) -> None:
        """Advance the sink, and measure simulated robots if that is due."""
        if self.run.score is EMPTY:
            return  # before the first score, performance time is the clock's
        self.sink.advance(performed)
        self.advanced = max(self.advanced, performed)
        period = performed // MEASURE_PERIOD
        if period > self.measured and not self.sink.real and self.odometry.robots:
            self.measured, at = period, self.run.transport.clock(performed)
            poses = {robot: pose for robot, pose in self.sink.poses().items() if robot in self.odometry.robots}
            self.moved = None if poses == self.moved else poses
            self.measure([RawPose(robot, SIMULATED, pose, at) for robot, pose in poses.items()], at)

    def begin(self, robots: Collection[str], beat: Exact, performed: float, now: float) -> None:
        """Have robots play their parts of this scene from a beat on, starting at this performance time."""
        self.queue.begin(robots)
        for robot in robots:
            self._begin(Mover(robot), beat, performed)
            for mover in self._begin_limbs(robot, beat, performed):
                self.queue.add(mover, zeros(0.0, 1 / self.run.score.parts[robot].profile.command_rate), performed)
        self.active_parts.complete(self.run)
        self.unsettled = True
        self.listeners.wait(now)
        if not self.active_parts.asked:  # robots come first; what open parts decide is reported after they begin
            self._send_changes(performed)

    def _begin(self, mover: Mover, beat: Exact, performed: float) -> None:
        part = self.run.score.parts[mover.robot]
        movement = whole = part.of_scene(self.run.scene)
        if mover.part:
            movement = self.limbs.track[mover].performs(whole)
        if open_part := self.active_parts.begin(self.run, mover, movement, beat, whole.body_words.has_poses):
            self.queue.begin_open(mover, self.run.transport.end(open_part.due))
        elif not mover.part:
            self.queue.add(mover, self.beginning.part(self.run, mover.robot, beat), performed)

    def _begin_limbs(self, robot: str, beat: Exact, performed: float) -> list[Mover]:
        """Have a robot's body parts play. Return those that have nothing to do now, but may still move."""
        part, left = self.run.score.parts[robot], self.queue.movers([robot])[1:]
        for mover in self.limbs.movers_of(part, self.run.tempo):
            track = self.limbs.track[mover]
            track.settle(performed)
            track.begin(part.begins)
            self._begin(mover, beat, performed)
        return [mover for mover in left if mover not in self.active_parts.open]

    # Senses

    def sense(self, what: RobotSense, value: bool | None, at: float, now: float) -> None:
        """Take the value of a robot's sense since a time on the clock, and have the robot react."""
        self.sensing.take(what, value)
        if not self.sensing.is_forced(what):
            self.react(what, at, now)

    def react(self, what: RobotSense, at: float, now: float) -> None:
        """Have a robot react to its sense since a time on the clock. What it has performed can't be changed."""
        run, part = self.run, self.run.score.parts.get(what.robot)
        if self.sensing.follows or not part or what.sense not in part.senses:
            return
        performed = max(min(run.transport.performed(min(at, now)), run.transport.performed(now)), 0.0)
        beat = run.beat(run.transport.clock(performed), self.active_parts.over)
        movers = self.active_parts.open_of(what.robot) if run.mode == "playing" else []
        for mover in movers:
            beat = self.active_parts.open[mover].next_after(beat)
        self.sensing.cued = what.sense == CUE
        self.tell_sensed(what, self.sensing.value(what, run.score), beat, performed, now)
        self._perform_begun(movers, beat, max(performed, self.advanced))
        self.sensing.cued = False

    def _feel(self, performed: float) -> bool:
        """Advance the sink to the first edges that it finds until then, and take them. Return whether it found any."""
        if self.sensing.follows or self.run.mode != "playing" or performed < self.advanced:
            return False
        edges = self.sink.advance(performed, self.active_parts.asked)
        for edge in edges:
            assert isinstance(edge.what, RobotSense)
            self.advanced = max(self.advanced, edge.at)
            at = self.run.transport.clock(edge.at)
            self.sense(edge.what, edge.value, at, at)
        if not edges:
            self.advanced = max(self.advanced, performed)
        return bool(edges)

    def _take_announced(self, at: float) -> None:
        edges, robots = self.sensing.take_announced(), {}
        for beat, what, value in edges:
            if self.sensing.replays and what.robot in self.run.score.parts:
                self.tell_sensed(what, value, beat, at, self.run.transport.clock(at))
            robots[what.robot] = what.sense == CUE
        for robot, self.sensing.cued in robots.items():
            self._perform_begun(self.active_parts.open_of(robot), edges[0].beat, max(at, self.advanced))
        self.sensing.cued = False

    def _perform_begun(self, movers: Iterable[Mover], beat: Exact, at: float) -> None:
        with self.joints.together():
            for mover in movers:
                if self.active_parts.open[mover].has_begun:
                    self.queue.drop_changes([mover])
                    self._perform(mover, beat, at)
                    self._plan(mover, at)

    def _perform(self, mover: Mover, beat: Exact, at: float) -> None:
        """Perform an open part up to a beat, and send the result to its mover from this performance time on."""
        part, track = self.run.score.parts[mover.robot], self.limbs.track[mover] if mover.part else None
        if track:
            track.settle(at)
        try:
            for decision in self.active_parts.perform(mover, beat):
                if not track:  # body parts decide the same
                    self.tell(reports.decided(self.run, mover.robot, decision, at, self.wall()))
        except TooManyChangesError:
            line = f"{mover} stops: its part changes more often than it can be performed"
            self.tell({"type": "error", "message": line})
        open_part, rate = self.active_parts.open.get(mover), part.profile.command_rate
        if not open_part:
            self.queue.drop([mover])
            self.queue.add(mover, zeros(0.0, 1 / rate), at)
            return
        asked, tempo = open_part.velocity, self.run.tempo
        self.queue.hold(mover, track.speeds(asked, tempo) if track else twist(asked, part.profile, tempo), rate, at)

    def _plan(self, mover: Mover, at: float) -> None:
        """Schedule the next performance of an open part, which was performed at this performance time."""
        if open_part := self.active_parts.open.get(mover):
            limit_at = self.limbs.track[mover].limit_at if mover.part else math.inf
            self.queue.add_open(mover, open_part.plan(self.run.transport, at, limit_at))

    # Velocities

    def _ready(self, commands: Sequence[MoverCommand]) -> Callable[[], None]:
        """Get commands ready, and return a function that sends them: those to bases first, and then notes these."""
        bases, limbs = list[tuple[str, Twist, float]](), list[Callable[[], None]]()
        for mover, velocity, performed in commands:
            if mover.part:
                limbs.append(partial(self.joints.move, mover.robot, self.limbs.track[mover], velocity, performed))
            else:
                assert isinstance(velocity, Twist)
                bases.append((mover.robot, velocity, performed))
        clock, pace = self.run.transport.clock, self.run.simulated_pace
        earliest = self.reached if self.sink.real else -math.inf
        told = [self.odometry.corrected(robot, twist, max(clock(at), earliest)) for robot, twist, at in bases]
        sends = self.sink.ready(
            [
                BaseCommand(robot, twist if pace == 1 else twist.times(1 / pace), at)
                for (robot, _, at), twist in zip(bases, told, strict=True)
            ]
        )

        def send() -> None:
            try_all([sends, *limbs])
            for (robot, wanted, performed), sent in zip(bases, told, strict=True):
                at = clock(performed)
                self.odometry.tell(robot, wanted, at)
                if self.sink.real:
                    self.faults.tell(robot, wanted, at)
                    self.separation.tell(self.run, robot, sent, max(at, self.reached))

        return send

    def _stands(self, robot: str) -> bool:
        return self.run.mode == "playing" and self.run.stands(robot, self.listeners.standing)

    def _withhold(self, command: MoverCommand) -> None:
        """Take a command that a standing robot isn't sent. If the robot drives back, it joins its part where this
        command leads."""
        mover, velocity, performed = command
        if mover.robot in self.listeners.returning and not mover.part and isinstance(velocity, Twist):
            self.odometry.tell(mover.robot, velocity, self.run.transport.clock(performed))

    # Facts and reports

    def facts(self, now: float, event: Event | None = None, late: float = 0.0) -> Facts:
        """Return the facts at a time for the decision of an event, which other stages did `late` seconds ago."""
        entering = isinstance(event, (Play, Due)) and self.run.score.open and not self.sink.real
        poses = self.sink.poses() if entering else {}
        places = self.odometry.places(now) if self.sink.real else {}
        if places:
            places = {robot: each for robot, each in places.items() if robot not in self.listeners.returning}
        sees = self.sink.real and self.run.score.safety.sight
        return Facts(
            now=now,
            real=self.sink.real,
            over=self.active_parts.over,
            late=late,
            away=frozenset(self.listeners.away),
            standing=frozenset(self.listeners.standing),
            held=self.sensing.held,
            poses=poses,
            places=places,
            wall=self.wall() if self.run.gate else 0.0,
            unseen=self.separation.unseen(self.run, now) if sees else (),
            unreached=self.faults.unreached if self.sink.real else (),
            other_publishers=self.sink.other_publishers(),
            unheard=isinstance(event, Due) and self.sink.real and self.listeners.unheard,
            paths=self.paths,
        )

    def tell_sensed(self, what: RobotSense, value: bool | None, beat: Exact, performed: float, now: float) -> None:
        """Report the value of a robot's sense. `now` is the present time on the clock."""
        wall = self.wall() - (now - self.run.transport.clock(performed))
        self.tell(reports.sensed(self.run, what, value, beat, performed, wall))

    def measure(self, poses: Iterable[RawPose], now: float) -> None:
        """Take measured poses, and report where robots were and where they ideally would have been."""
        self.queue.forget_prepared()  # they correct velocities
        run, poses = self.run, [raw for raw in poses if self.odometry.fits(raw)]
        found = [comparison for raw in poses if (comparison := self.odometry.take(raw))]
        if self.sink.real:
            strays = self.odometry.strays
            taken = [raw._replace(at=self.odometry.taken_at(raw)) for raw in poses]
            self.separation.hear(run, [raw for raw in taken if raw.robot not in strays])
            if seen := self.separation.shared(run, taken):
                self.tell(seen)
            for comparison in found:
                self.faults.take(comparison)
        if found and (not self.sink.real or now < self.measured_until):
            robots = {
                each.raw.robot: reports.compared(run, self.active_parts.over, each, self.wall() - (now - each.raw.at))
                for each in found
            }
            self.tell({"type": "measured", "generation": run.generation, "robots": robots})

    def look(self, robots: Collection[str]) -> None:
        """Check robots at once, and report problems."""
        self.queue.silence(self.listeners.look(self.run.score, robots))
        self.tell_news()

    def tell_news(self) -> None:
        for line in self.listeners.news():
            self.tell({"type": "warning", "message": line})
