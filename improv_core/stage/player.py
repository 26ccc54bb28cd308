"""Plays scores: sends setpoints when they are due and obeys commands. It never reads a clock; callers pass the time in.

`now` is the clock's time in seconds. `performed` and `at` are performance times: seconds since the latest restart,
including pauses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import replace
from fractions import Fraction

from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.movement import ENDLESS, Exact, near
from improv_core.score.path import pose_at
from improv_core.score.performer import Decision
from improv_core.score.score import Score, twist
from improv_core.score.senses import CUE, BuiltIn, Key, RobotSense
from improv_core.score.transport import BEATS_PER_BAR, Switch, Transport
from improv_core.stage.current_scene import CurrentScene
from improv_core.stage.interlocks import stop_of, waits_for
from improv_core.stage.listeners import Listeners
from improv_core.stage.odometry import Comparison, Odometry
from improv_core.stage.open_part import TooManyChangesError
from improv_core.stage.protocol import (
    FASTEST,
    LAST_BEAT,
    SIMULATED,
    SLOWEST,
    Begins,
    Decided,
    Entry,
    ErrorLine,
    Measured,
    MeasuredRobot,
    Moment,
    PoseJson,
    Poses,
    Sensed,
    State,
    TransportMessage,
    Waiting,
    WarningLine,
    When,
    is_silent,
    refused_by,
    to_pose_json,
)
from improv_core.stage.sensing import Foreseen, Sensing
from improv_core.stage.setpoint_queue import SetpointQueue
from improv_core.stage.setpoints import zeros
from improv_core.stage.sinks import Edge, RawPose, Sink
from improv_core.stage.swap import Before, Swap, edited, entering, joined, never_ends

LOOK_AGAIN = 0.01
"""Seconds between two checks for listeners before beat 0, and of robots that still move after the end."""
LATE = 0.5
"""Seconds by which setpoints may be late. After that, real robots are stopped: they have stopped by themselves, or
should have."""

MEASURE_PERIOD = 0.05
"""Seconds between two measurements of a simulated robot."""
REST = 1.0
"""Seconds for which robots are still measured after they were told to stop: most have come to rest by then."""

Told = TransportMessage | Sensed | Decided | Measured | WarningLine | ErrorLine
EMPTY = Score(Fraction(60), {})


class Player:
    """Plays one score at a time on a sink and reports what it does in messages (see docs/protocol.md)."""

    def __init__(self, sink: Sink, tell: Callable[[Told], None], wall: Callable[[], float]) -> None:
        self._sink = sink
        self._tell = tell
        self._wall = wall
        self.backend = sink.name
        """What everything plays on, in words for people."""
        self._generation = self._restarted = 0
        self._begun = EMPTY  # the score as it took over, before scenes began that could not be foreseen
        self._state: State = "stopped"
        self._speed = Fraction(1)
        self._transport = Transport(0.0, 0.0, 0, EMPTY.tempo)
        self._odometry = Odometry()
        self._measured = -math.inf  # the period in which simulated robots were measured last
        self._measured_until = -math.inf  # the time on the clock at which robots that stop have come to rest
        self._queue = SetpointQueue(self._send, lambda robot: self._state == "playing" and self._is_silent(robot))
        self._next: Swap | None = None
        self._muted: frozenset[str] = frozenset()
        self._soloed: frozenset[str] = frozenset()
        self._sensing = Sensing()
        self._scene = CurrentScene(EMPTY, self._sensing)
        self._advanced = 0.0  # the performance time up to which the sink has been advanced
        self._listeners = Listeners(sink)
        self._continues = False  # whether a pause ends by itself once nothing is waited for
        self.reached = 0.0
        """The time on the clock up to which everything has been sent."""
        self._start_poses: dict[str, PoseJson] = {}

    @property
    def state(self) -> State:
        """stopped, waiting (for listeners), playing, paused, or ended."""
        return self._state

    @property
    def generation(self) -> int:
        """The number of the score that plays, or played last."""
        return self._generation

    @property
    def score(self) -> Score:
        """The score that plays, or played last, with the beats at which its parts began."""
        return self._scene.score

    def load(
        self,
        score: Score,
        generation: int,
        when: When,
        now: float,
        entry: Entry | None = None,
        beats_per_bar: int = BEATS_PER_BAR,
        senses: Iterable[Foreseen] | None = None,
    ) -> None:
        """Play a score: `restart` from beat 0 and start poses, or take over `now`, at the next `beat` or `bar`, or at
        the `end`.

        A score that takes over is an edit of the one that plays: the beat keeps counting, parts of the same edition
        stay as they are, and all others begin. `entry` says when, if another stage has decided it. If playback is
        paused, the score continues from there; if nothing plays, it restarts. If `senses` are given, robots sense these
        and nothing else after a restart.
        """
        if self._sink.real and (stop := stop_of(score.safety, self._sensing)):
            self._tell({"type": "error", "message": refused_by(stop)})
            self._tell_transport(now)
            return
        beats_per_bar, performed = max(beats_per_bar, 1), self._transport.performed(now)
        if when == "restart" or not (self._state in ("playing", "paused") or (self._state == "ended" and entry)):
            self._restart(score, generation, now, entry, senses)
            return
        if entry:
            at = entry["monotonic"] - self._transport.zero
        elif self._state == "paused":
            at = performed
        else:
            at = self._switch_time(when, performed, beats_per_bar)
        swap = Swap(score, generation, when, beats_per_bar, at, entry)
        if self._state == "paused":
            self._next = None
            self._take_over(swap, now)
        else:
            self._sink.meet(score)  # at the beat there is no time for that
            self._next = swap
            self.advance(now)

    def hush(self, now: float) -> None:
        """Stop every robot at once. If one can't be stopped, the others still are, and the first exception is raised.

        Does nothing while it waits for listeners only so that it can stop their robots: none of them would hear it yet.
        """
        if self._state == "waiting" and not (self.score.beats or self.score.open):
            return
        self._stop_all(now, "stopped")

    def pause(self, now: float) -> None:
        """Stop every robot at once, to resume from here later."""
        self._catch_up(now)
        self._continues = False
        if self._state == "playing":
            self._stop_all(now, "paused")

    def resume(self, now: float) -> None:
        """Continue from where it was paused, as soon as nothing is waited for."""
        if self._state == "paused":
            self._play_from(self._transport.origin, self._transport.performed(now), now)

    def sense(self, edge: Edge, now: float) -> None:
        """Handle a change. An emergency stop stops all robots, releasing the deadman button pauses them, and a sense
        makes its robot react."""
        if isinstance(edge.what, RobotSense):
            self._catch_up(max(min(edge.at, now), self.reached))
            self._sense(edge.what, edge.value, edge.at, now)
            return
        before = self._sensing.latest(edge.what)
        self._sensing.take(edge.what, edge.value)
        if edge.what == self.score.safety.stop:
            if edge.value:
                self.hush(now)
                what = f"the emergency stop on {edge.what} is on, so all robots were stopped"
                self._tell({"type": "error", "message": what})
            elif before:
                self._tell_transport(now)  # first, so that a person who reads the line and saves is not refused
                what = f"the emergency stop on {edge.what} is off: save to play again"
                self._tell({"type": "warning", "message": what})
        self._keep_waiting(now)

    def measure(self, poses: Iterable[RawPose], now: float) -> None:
        """Take measured poses, and report where robots were and where they ideally would have been."""
        found = [comparison for raw in poses if (comparison := self._odometry.take(raw))]
        if found and (self._state == "playing" or (self._state != "waiting" and now < self._measured_until)):
            robots = {each.raw.robot: self._compared(each, now) for each in found}
            self._tell({"type": "measured", "generation": self._generation, "robots": robots})
        for line in self._odometry.news():
            self._tell({"type": "warning", "message": line})

    def cue(self, now: float) -> None:
        """Give the cue, which holds for an instant."""
        self._catch_up(now)
        for robot, part in list(self.score.parts.items()):
            if isinstance(part.senses.get(CUE), BuiltIn):
                self._sense(RobotSense(robot, CUE), True, now, now)

    def hold_key(self, key: str, held: bool, now: float) -> None:
        """Somebody holds or releases a key: the senses that are declared with it become true or false."""
        self._catch_up(now)
        self._sensing.hold_key(key, held)
        for robot, part in list(self.score.parts.items()):
            for sense, source in part.senses.items():
                if isinstance(source, Key) and source.key == key and not self._sensing.follows:
                    self._sense(RobotSense(robot, sense), held, now, now)

    def force(self, what: RobotSense, value: bool | None, now: float) -> None:
        """Make a simulated robot sense something, whatever is around it. None ends that."""
        if self._sink.real:
            line = f"{what.robot} is a real robot: its senses can't be forced"
            self._tell({"type": "warning", "message": line})
            return
        self._catch_up(now)
        self._sensing.force(what, value)
        if what.robot in self.score.parts:
            self._react(what, now, now)

    def foresee(self, edge: Foreseen, now: float) -> None:
        """Take an edge at its beat, as the stage that leads has reported it."""
        self._sensing.announce([edge])
        if self._state == "playing":
            self.advance(now)

    def seek(self, beat: float, now: float) -> None:
        """Jump to another beat and keep playing, or stay paused there. Simulated robots move to their poses there.

        What senses have decided is forgotten: up to that beat, it is as if none had been true. Ignored if nothing has
        been loaded.
        """
        if self.score is EMPTY:
            return
        target = near(min(max(beat, 0.0), float(self._begun.beats), LAST_BEAT))
        self._enter(self._begun, target)
        if self._state != "waiting":
            self._place_at(target, now)
        if self._state == "playing":
            self._play_from(target, self._transport.performed(now), now)
        elif self._state != "waiting":
            self._leave_at(target)
            self._state = "paused"
            self._tell_transport(now)

    def set_speed(self, factor: float, now: float) -> None:
        """Set the speed factor, 0.1 to 4. Later scores keep it."""
        self._catch_up(now)
        beat = self._beat(now)
        self._speed = Fraction(str(min(max(factor, SLOWEST), FASTEST)))
        if self._state == "playing":
            self._play_from(beat, self._transport.performed(now), now)
        else:
            self._transport = replace(self._transport, tempo=self._tempo)
            self._tell_transport(now)

    def set_silent(self, muted: Collection[str], soloed: Collection[str], now: float) -> None:
        """Have muted robots, or all except soloed ones, stand still while others play. Applies to later scores too."""
        self._catch_up(now)
        before = {robot for robot in self.score.parts if self._is_silent(robot)}
        self._muted, self._soloed = frozenset(muted), frozenset(soloed)
        for robot in self.score.parts if self._state == "playing" else ():
            if self._is_silent(robot) != (robot in before):
                self._queue.resend(robot, max(self._transport.performed(now), self._transport.since))
        self._tell_transport(now)

    def advance(self, now: float) -> None:
        """Send everything that is due."""
        if self._state == "waiting":
            self._look_for_listeners(now)
            if self._state == "waiting":
                return
        if self._sink.real and self._state == "playing" and self._transport.performed(now) - self._due() > LATE:
            late = self._transport.performed(now) - self._due()
            self.hush(now)
            message = f"the stage stalled for {late:.1f} s, so all robots were stopped: save to play again"
            self._tell({"type": "error", "message": message})
            return
        if self._sink.real and self._queue.repeats.hopeless:
            self.hush(now)
            count = len(self.score.parts)
            message = f"this machine is too slow for {count} robots, so all were stopped: play fewer robots"
            self._tell({"type": "error", "message": message})
            return
        self.reached = now
        performed = self._performed(now)
        if self._scene.asked:  # what is sensed until then decides when the scene ends
            swap_at = self._next.at if self._next else math.inf
            self._send_changes(min(performed, math.nextafter(swap_at, -math.inf)))
            performed = self._performed(now)
        if self._next and self._state != "paused" and performed >= self._next.at and not self._next_begins_first:
            swap, self._next = self._next, None
            # At exactly this time, the new score's setpoints replace those of the old one. A repeat that is due waits
            # for them: what it repeats may be about to change.
            self._send_changes(math.nextafter(swap.at, -math.inf))
            self._take_over(swap, now)
        end = self._transport.end(self._scene.ends)
        if self._state == "playing" and performed >= end:
            self._send_due(end)
            self._end(end, now)
        self._send_due(performed)
        if self._sink.real and (line := self._queue.repeats.news()):
            self._tell({"type": "warning", "message": line})
        if now >= self._listeners.next_look and (self._state == "playing" or self._looks_while_paused):
            standing, done = self._listeners.look_around(self.score, now)
            self._queue.silence(standing)
            if done:
                self._tell_news()
            self._keep_waiting(now)

    def deadline(self, now: float) -> float | None:
        """The time on the clock at which `advance` must be called next; None if nothing is left to do."""
        if self._state == "waiting":
            return now + LOOK_AGAIN
        due = self._due()
        if due == math.inf and self._looks_while_paused:
            return self._listeners.next_look
        if due == math.inf:
            return now + (self._sink.period or LOOK_AGAIN) if self._sink.coasting() else None
        at = self._transport.clock(due)
        return min(at, now + self._sink.period) if self._sink.period else at

    @property
    def _before_next_scene(self) -> float:
        """The last performance time at which this scene may send anything; infinite if no scene follows it."""
        if self._state != "playing" or not self._scene.has_next:
            return math.inf
        return math.nextafter(self._transport.end(self._scene.ends), -math.inf)

    @property
    def _next_begins_first(self) -> bool:
        """Whether the next scene begins before the next score takes over."""
        if not (self._next and self._scene.has_next and self._state == "playing"):
            return False
        return self._transport.end(self._scene.ends) <= self._next.at

    @property
    def is_exact(self) -> bool:
        """Whether what is due next must be sent at its exact time. Repeats may be a little late."""
        return self._change_due() <= self._queue.repeats.due

    @property
    def _looks_while_paused(self) -> bool:
        """Whether playback waits for robots that have gone away."""
        return self._state == "paused" and self._continues and bool(self._listeners.away)

    @property
    def _tempo(self) -> Fraction:
        """The actual tempo in beats per minute, including the speed factor."""
        return self.score.tempo * self._speed

    def _beat(self, now: float) -> Exact:
        """The current beat of the score."""
        playing = self._state == "playing"
        return self._transport.beat(now, self._scene.beats) if playing else self._transport.origin

    def _place_at(self, beat: Exact, now: float) -> None:
        """Move simulated robots to where they ideally are at a beat. Real ones count as being there."""
        real = self._sink.real
        parts = {robot: part for robot, part in self.score.parts.items() if part.odom or not real}
        ideal = {robot: pose_at(part, beat) for robot, part in parts.items()}
        poses = {robot: pose for robot, pose in ideal.items() if pose}
        self._odometry.place(poses, now)
        if not real:
            self._sink.place(poses)

    def _leave_at(self, beat: Exact) -> None:
        """Remember the beat at which playback stopped."""
        self._transport = replace(self._transport, origin=beat)

    def _due(self) -> float:
        """The performance time of the next event."""
        return min(self._change_due(), self._queue.repeats.due)

    def _change_due(self) -> float:
        """The performance time of the next event that has an exact time. Repeats may be a little late."""
        swap = self._next.at if self._next and self._state != "paused" else math.inf
        end = self._transport.end(self._scene.ends) if self._state == "playing" else math.inf
        return min(self._queue.due, swap, end, self._foreseen_at)

    @property
    def _foreseen_at(self) -> float:
        """The performance time of the next edge that was announced."""
        beat = self._sensing.announced
        return math.inf if beat is None or self._state != "playing" else self._transport.end(beat)

    def _switch_time(self, when: Switch, performed: float, beats_per_bar: int) -> float:
        """When another score takes over. One that waits for the end of an open score waits until that is known."""
        beats = self._scene.beats
        if when == "end" and beats == ENDLESS and not never_ends(self.score):
            return math.inf
        return self._transport.switch_time(when, performed, beats, beats_per_bar)

    def _performed(self, now: float) -> float:
        """The current performance time. Rounding never puts it before an event that is due on the clock."""
        due = self._due()
        performed = self._transport.performed(now)
        return max(performed, due) if self._transport.clock(due) <= now else performed

    def _restart(
        self, score: Score, generation: int, now: float, entry: Entry | None, senses: Iterable[Foreseen] | None
    ) -> None:
        old, performed = self.score.parts, self._transport.performed(now)
        for robot in old.keys() - score.parts.keys():
            self._sink.send(robot, STILL, performed)
        self._queue.leave_topics(old, score.parts, performed)
        self._sink.prepare(score, True)
        self._start_poses = _as_json(self._sink.poses())
        self._queue.restart({*old, *score.parts}, performed)
        self._next, self._advanced, self._measured = None, 0.0, -math.inf
        self._odometry.begin(score.parts, now)
        self._sensing.restart(follows=entry is not None or senses is not None, replays=senses is not None)
        self._queue.stop_leaving(old, score.parts, 0.0)
        self._listeners.forget()
        self._listeners.begin(score, {*old, *score.parts}, now)
        self._generation = self._restarted = generation
        self._enter(score, 0)
        self._sensing.announce(senses or ())
        self._transport = Transport(entry["monotonic"] if entry else now, 0.0, 0, self._tempo)
        self._listeners.expect(score.parts)
        self._state = "waiting"
        if entry:
            self._join(entry, now)
            return
        self._look_for_listeners(now)
        if self._state == "waiting":
            for robot in old.keys() & score.parts.keys():
                self._sink.send(robot, STILL, 0.0)  # they must not keep moving while we wait for others
            self._tell_transport(now)

    def _join(self, entry: Entry, now: float) -> None:
        """Play from the beat on that another stage has reached, since it may have begun long ago."""
        beat = near(entry["beat"])
        self._enter(joined(self.score, entry), beat)
        if beat:
            self._place_at(beat, now)
        self._play_from(beat, 0.0, now)

    def _look_for_listeners(self, now: float) -> None:
        found, awaits = self._listeners.find(now)
        for robot in found:
            part = self.score.parts[robot]
            if not part.movement.duration and not any(scene.open for scene in part.scenes):
                self._sink.send(robot, STILL, 0.0)  # a robot that only has to stop need not wait for the others
        if self._sink.resetting() or awaits:
            return
        self._transport = replace(self._transport, zero=now)
        self._odometry.begin(self.score.parts, now)
        self._play_from(0, 0.0, now)
        self._look_at(self.score.parts)

    def _take_over(self, swap: Swap, now: float) -> None:
        """Have a score take over. Parts that stay the same are not touched: what is due in them is sent first."""
        old, paused = self.score, self._state == "paused"
        beat = self._transport.origin if paused and not swap.entry else swap.beat(self._transport)
        poses = None if self._sink.real else self._sink.poses() if old.open else {}
        before = Before(old, self._scene.index, self._scene.is_over(beat), poses)
        score = edited(swap, beat, before)
        begin = entering(score, before)
        goes_on = self._state == "playing" and score.tempo == old.tempo and not swap.shifts(self._transport)
        leaving = old.parts.keys() - score.parts.keys()
        self._queue.drop({*begin, *leaving} if goes_on else {*old.parts, *score.parts})
        self._send_due(swap.at)
        self._queue.leave_topics(old.parts, score.parts, swap.at)
        self._sink.prepare(score, False)
        self._listeners.begin(score, begin, now)
        self._queue.stop_leaving(old.parts, score.parts, swap.at)
        self._odometry.cast(score.parts, now)
        self._begun, self._generation = score, swap.generation
        self._scene.edit(score, {*begin, *leaving})
        if goes_on and not self._waits_for():
            self._begin(begin, beat, swap.at, now)
        else:
            self._play_from(beat, swap.at, now)
        self._look_at(begin)

    def _enter(self, score: Score, beat: Exact) -> None:
        """Get ready to play a score from a beat on as if no sense had held before."""
        self._begun = score
        self._scene.enter(score, beat)
        self._sensing.forget_announced()

    def _end(self, end: float, now: float) -> None:
        """The scene is over: the next one begins, or another score, or nothing."""
        beat = self._scene.ends
        assert not isinstance(beat, float)
        if self._scene.has_next:
            self._scene.enter_next(beat, self._sink.poses() if self.score.open else {})
            # Report its beat if that was not known in advance.
            self._begin(self.score.parts, beat, end, now, tells=self.score is not self._begun)
            return
        if self._next and self._next.at == math.inf:
            swap, self._next = replace(self._next, at=end), None
            self._take_over(swap, now)
            return
        self._transport = replace(self._transport, since=end, origin=beat)
        self._state, self._measured_until = "ended", now + REST
        if not self._sink.real:
            self._look_at(self.score.parts)  # for bumps in the last second
        self._tell_transport(now)

    def _play_from(self, beat: Exact, performed: float, now: float) -> None:
        """Play the score from a beat on, starting at this performance time."""
        self._transport = Transport(self._transport.zero, performed, beat, self._tempo)
        if self._waits_for():
            self._state = "paused"
            self._wait(now)
            return
        self._state, self._continues = "playing", False
        if swap := self._next:
            self._next = replace(swap, at=self._switch_time(swap.when, performed, swap.beats_per_bar))
        self._begin(self.score.parts, beat, performed, now)

    def _begin(self, robots: Collection[str], beat: Exact, performed: float, now: float, *, tells: bool = True) -> None:
        """Have robots play their parts of this scene from a beat on, starting at this performance time."""
        self._queue.begin(robots)
        for robot in robots:
            if open_part := self._scene.cast(robot, beat):
                self._queue.begin_open(robot, self._transport.end(open_part.due))
            else:
                self._queue.add(robot, self._scene.told(robot, self._tempo, beat), performed)
        self._scene.begin()
        self._listeners.wait(now)
        if not self._scene.open:  # robots come first; what open parts decide is told after their beginning
            self._queue.send_changes(performed, self.score.parts, self._perform_due)
        if tells:
            self._tell_transport(now, self._transport.clock(performed))
        for what in self._scene.asked if tells else ():
            if not self._sensing.follows and self._sensing.latest(what) is not None:
                value = self._scene.value(what)
                self._tell_sensed(what, value, beat, performed, now)
        self.advance(now)

    def _sense(self, what: RobotSense, value: bool | None, at: float, now: float) -> None:
        """A robot has sensed something since a time on the clock: have it react."""
        self._sensing.take(what, value)
        if not self._sensing.is_forced(what):
            self._react(what, at, now)

    def _react(self, what: RobotSense, at: float, now: float) -> None:
        """Have a robot react to what it has sensed since a time on the clock. What it has performed can't be
        changed."""
        part = self.score.parts.get(what.robot)
        if self._sensing.follows or not part or what.sense not in part.senses:
            return
        performed = max(min(self._transport.performed(min(at, now)), self._transport.performed(now)), 0.0)
        playing = self._state == "playing"
        beat = self._beat(self._transport.clock(performed))
        open_part = self._scene.open.get(what.robot)
        if playing and open_part:
            beat = open_part.next_after(beat)
        self._sensing.cued = what.sense == CUE
        value = self._scene.value(what)
        self._tell_sensed(what, value, beat, performed, now)
        if playing and open_part and open_part.has_begun:
            self._perform(what.robot, beat, max(performed, self._advanced))
        self._sensing.cued = False

    def _take_foreseen(self, at: float) -> None:
        """Take the edges that were announced and are due."""
        edges, robots = self._sensing.take_announced(), {}
        for beat, what, value in edges:
            if self._sensing.replays and what.robot in self.score.parts:
                self._tell_sensed(what, value, beat, at, self._transport.clock(at))
            robots[what.robot] = what.sense == CUE
        for robot, self._sensing.cued in robots.items():
            if (open_part := self._scene.open.get(robot)) and open_part.has_begun:
                self._perform(robot, edges[0].beat, max(at, self._advanced))
        self._sensing.cued = False

    def _perform_due(self, robot: str, at: float) -> None:
        self._perform(robot, self._scene.open[robot].due, at)

    def _perform(self, robot: str, beat: Exact, at: float) -> None:
        """Perform a robot's open part up to a beat, and tell it what to do from this performance time on."""
        part = self.score.parts[robot]
        try:
            for decision in self._scene.perform(robot, beat):
                self._tell_decided(robot, decision, at)
        except TooManyChangesError:
            line = f"{robot} stops: its part changes more often than it can be performed"
            self._tell({"type": "error", "message": line})
        open_part = self._scene.open.get(robot)
        if not open_part:
            self._queue.drop([robot])
            self._queue.add(robot, zeros(0.0, 1 / part.profile.command_rate), at)
            return
        self._queue.drop_changes([robot])
        self._queue.hold(robot, twist(open_part.velocity, part.profile, self._tempo), part.profile.command_rate, at)
        self._queue.add_open(robot, open_part.plan(self._transport, at))

    def _waits_for(self) -> list[str]:
        """What has to change before real robots may move."""
        return waits_for(self.score.safety, self._sensing, self._listeners.away) if self._sink.real else []

    def _wait(self, now: float) -> None:
        """Pause until nothing has to be waited for. After an emergency stop, somebody has to play again."""
        if stop := stop_of(self.score.safety, self._sensing):
            self._stop_all(now, "stopped")
            self._tell({"type": "error", "message": refused_by(stop)})
            return
        self._stop_all(now, "paused", continues=True)
        self._listeners.wait(now)
        first = self._waits_for()[0]
        what = (
            f"paused until {first} listens again"
            if first in self._listeners.away
            else f"paused: to let robots move, hold {first}"
        )
        self._tell({"type": "warning", "message": what})

    def _keep_waiting(self, now: float) -> None:
        """Pause or resume, depending on what has to be waited for now."""
        waits = self._waits_for()
        if waits and self._state == "playing":
            self._wait(now)
        elif not waits and self._state == "paused" and self._continues:
            self.resume(now)

    def _catch_up(self, now: float) -> None:
        """Send what is due before something changes, so robots don't miss it."""
        if self._state == "playing":
            self.advance(now)

    def _stop_all(self, now: float, state: State, continues: bool = False) -> None:
        performed = self._transport.performed(now)
        self._continues = continues
        if state != "paused":
            self._next = None
        problems = self._queue.stop(self.score.parts, performed)
        self._leave_at(self._beat(now))
        self._state, self.reached, self._measured_until = state, now, now + REST
        if problems:
            raise problems[0]
        self._advance_sink(performed)
        self._tell_transport(now)

    def _send(self, robot: str, twist: Twist, performed: float) -> None:
        at = self._transport.clock(performed)
        correction = self._odometry.correction(robot, twist, max(at, self.reached) if self._sink.real else at)
        self._sink.send(robot, twist if correction == STILL else twist.plus(correction), performed)
        self._odometry.tell(robot, twist, at)

    def _is_silent(self, robot: str) -> bool:
        return robot in self._listeners.standing or is_silent(robot, self._muted, self._soloed)

    def _send_due(self, performed: float) -> None:
        """Send every change that is due, and then the repeats of one slot, so that a change never waits for more."""
        performed = self._send_changes(performed)
        self._queue.send_repeats(performed)
        self._advance_sink(performed)

    def _send_changes(self, asked: float) -> float:
        """Send every change until the performance time `asked`, also those that sensing causes. Returns how far that
        got: what comes after the end of a scene is not yet known."""
        while True:
            performed = min(asked, self._before_next_scene)
            first = min(self._queue.due, foreseen_at := self._foreseen_at)
            if self._scene.asked and self._feel(min(first, performed)):
                continue
            if first > performed:
                return performed
            if foreseen_at <= self._queue.due:
                self._take_foreseen(first)
                continue
            self._queue.send_changes(first if self._scene.asked else performed, self.score.parts, self._perform_due)

    def _feel(self, performed: float) -> bool:
        """Advance the sink to the first edges that it finds until then, and take them. Returns whether it found any."""
        if self._sensing.follows or self._state != "playing" or performed < self._advanced:
            return False
        edges = self._sink.sensed(self._scene.asked, performed)
        for edge in edges:
            assert isinstance(edge.what, RobotSense)
            self._advanced = max(self._advanced, edge.at)
            at = self._transport.clock(edge.at)
            self._sense(edge.what, edge.value, at, at)
        if not edges:
            self._advanced = max(self._advanced, performed)
        return bool(edges)

    def _advance_sink(self, performed: float) -> None:
        if self.score is EMPTY:
            return  # nothing has been loaded, so performance time is the clock's
        self._sink.advance(performed)
        self._advanced = max(self._advanced, performed)
        period = performed // MEASURE_PERIOD
        if period > self._measured and not self._sink.real and self._odometry.robots:
            self._measured, at = period, self._transport.clock(performed)
            poses = [each for each in self._sink.poses().items() if each[0] in self._odometry.robots]
            self.measure([RawPose(robot, SIMULATED, pose, at) for robot, pose in poses], at)

    def _look_at(self, robots: Collection[str]) -> None:
        """Check robots at once, and report what was found."""
        self._queue.silence(self._listeners.look(self.score, robots))
        self._tell_news()

    def _tell_news(self) -> None:
        for line in self._listeners.news():
            self._tell({"type": "warning", "message": line})

    def _moment(self, robot: str, beat: Exact, performed: float, now: float) -> Moment:
        """The fields that all edges and decisions have. `now` is the present time on the clock."""
        at = self._transport.clock(performed)
        return {
            "generation": self._generation,
            "robot": robot,
            "beat": float(beat),
            "performed": performed,
            "wall": self._wall_at(at, now),
        }

    def _wall_at(self, at: float, now: float) -> int:
        """The Unix time in nanoseconds at a time on the clock."""
        return round((self._wall() - (now - at)) * 1e9)

    def _compared(self, comparison: Comparison, now: float) -> MeasuredRobot:
        raw, pose, ideal, aligned, follows = comparison
        return {
            "source": raw.source,
            "frame": raw.frame,
            "origin": to_pose_json(raw.pose.then(pose.inverse())),
            "pose": to_pose_json(pose),
            "ideal": to_pose_json(ideal),
            "aligned": aligned,
            "follows": follows,
            "beat": float(self._beat(raw.at)),
            "performed": self._transport.performed(raw.at),
            "wall": self._wall_at(raw.at, now),
        }

    def whereabouts(self) -> Poses:
        """The poses of simulated robots at beat 0 and now; empty for real robots."""
        poses = _as_json(self._sink.poses())
        return {"start": self._start_poses, "poses": poses} if poses else {}

    def _tell_sensed(self, what: RobotSense, value: bool | None, beat: Exact, performed: float, now: float) -> None:
        robot, sense = what
        self._tell({"type": "sensed", "sense": sense, "value": value, **self._moment(robot, beat, performed, now)})

    def _tell_decided(self, robot: str, decision: Decision, performed: float) -> None:
        sources = [[source.statement, *source.span] for source in decision.sources]
        moment = self._moment(robot, decision.beat, performed, self._transport.clock(performed))
        self._tell({"type": "decided", "sources": sources, "held": decision.held, **moment})

    def _tell_transport(self, now: float, at: float | None = None) -> None:
        """Report the position and poses at a time on the clock (default: now). The sink must have advanced to it."""
        at = now if at is None else at
        beats = self.score.beats if self._state == "waiting" and not self.score.open else self._scene.beats
        waits = self._waits_for() if self._state in ("paused", "stopped") else []
        waiting: Waiting = {"waits_for": waits} if waits else {}
        begins = {robot: float(part.begins) for robot, part in self.score.parts.items() if part.begins}
        began: Begins = {"begins": begins} if begins else {}
        if self.score.scene or self.score.since:
            began["scene"] = {"index": self.score.scene, "begins": float(self.score.since)}
        message: TransportMessage = {
            "type": "transport",
            "generation": self._generation,
            "restarted": self._restarted,
            "state": self._state,
            "backend": self.backend,
            "tempo": float(self._tempo),
            "speed": float(self._speed),
            "beats": None if beats == ENDLESS else float(beats),
            "beat": float(self._beat(at)),
            "performed": self._transport.performed(at),
            "muted": sorted(self._muted),
            "soloed": sorted(self._soloed),
            "monotonic": at,
            "wall": self._wall() - (now - at),
            **self.whereabouts(),
            **waiting,
            **began,
        }
        self._tell(message)


def _as_json(poses: Mapping[str, Pose]) -> dict[str, PoseJson]:
    return {robot: to_pose_json(pose) for robot, pose in poses.items()}
