"""A stage's main loop: handles messages as they arrive, and plays in between. Callers pass it a clock."""

from __future__ import annotations

import math
import queue
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Protocol

from improv_core.ipc.arrivals import Arrival, DirectStop, End, First, Lost, Ordered, Unreadable
from improv_core.plain import one_line
from improv_core.player import events
from improv_core.player.player import Player
from improv_core.player.sensing import foreseen
from improv_core.player.separation_monitor import from_elsewhere
from improv_core.protocol.commands import VOIDED_BY_STOP, Pause, Stop, is_stop
from improv_core.protocol.limits import DEADMAN_LIMIT, END_LIMIT, SILENCE_LIMIT
from improv_core.protocol.messages import FromStage, Play, Stopped, ToStage
from improv_core.protocol.output import Alarm, Edge, RawJoints, RawPoses, Sink
from improv_core.safety.heartbeat import Parent
from improv_core.safety.interlocks import GAMEPAD
from improv_core.safety.stops import SLEPT
from improv_core.score.peer_clock import Anchor
from improv_core.score.profiles import beside_robots
from improv_core.score.score import Score
from improv_core.score.senses import Key
from improv_core.stage.command_queue import CommandQueue

EARLY = 0.0004
"""Seconds by which a stage with real robots wakes up before a setpoint is due, since the system wakes it 0.2 ms late.
A repeat doesn't need that."""
STOP: Stop = {"type": "stop"}
PAUSE: Pause = {"type": "pause"}
HALTED = events.Halted()
LATEST = 0.25
"""Seconds by which a score may come late, and still take over at the same beat as in other stages."""


class Inbox(Protocol):
    """A queue of arrivals, such as `ipc.arrivals.UrgentQueue`."""

    def get(self, *, timeout: float | None) -> Arrival:
        """Return the next arrival. Raises queue.Empty after `timeout` seconds without one (None: never)."""


class Clock(Protocol):
    """The time, in seconds: `now` is monotonic and stands still while the machine sleeps, `wall` is Unix time."""

    def now(self) -> float: ...

    def wall(self) -> float: ...

    def asleep(self) -> float:
        """Return for how long the machine has slept since it was started."""

    def wait_until(self, now: float) -> None:
        """Return at this monotonic time, as precisely as the system can."""


@dataclass(frozen=True, slots=True)
class OpenedOutput:
    """A sink, and functions that send a message to the parent and announce a score before any message about it."""

    sink: Sink
    tell: Callable[[FromStage], None]
    announce: Callable[[Score, int], None] = lambda score, generation: None


def run(opened: OpenedOutput, inbox: Inbox, clock: Clock, parent: Parent) -> int:
    """Play what arrives until the end, and stop the robots whatever ends it. Returns exit code 1 after a failure."""
    loop = Loop(opened, clock, parent)
    last: Stopped = {"type": "stopped"}
    try:
        while True:
            now = clock.now()
            deadline = loop.deadline(now)
            arrival = timeout = None
            if deadline < math.inf:
                early = 0.0
                if opened.sink.real and loop.player.is_exact:
                    early = EARLY
                    loop.player.prepare()
                timeout = max(deadline - early - clock.now(), 0)
            try:
                arrival = inbox.get(timeout=timeout)
            except queue.Empty:
                clock.wait_until(deadline)
            loop.wake(clock.now(), clock.asleep())
            if arrival is not None:
                if isinstance(arrival, End):
                    if not arrival.problem:
                        return 0
                    last["message"] = arrival.problem
                    return 1
                loop.take(arrival, clock.now())
            if (now := clock.now()) >= deadline:  # even if another arrival waits: robots must not wait for a flood
                loop.advance(now, now - deadline)
    except Exception as error:
        loop.failed = True
        # At once: to stop robots that have yet to be found may take longer than the parent waits for an answer.
        opened.tell({"type": "stopped", "message": one_line(error), **loop.player.whereabouts()})
        return 1
    finally:
        loop.stop()
        if not loop.failed:
            opened.tell({**last, **loop.player.whereabouts()})
        opened.sink.close()


class Loop:
    """The reaction of `run` to each arrival, and the time of the next thing to do."""

    def __init__(self, opened: OpenedOutput, clock: Clock, parent: Parent) -> None:
        self._opened = opened
        self._clock = clock
        self._parent = parent
        self._asleep = clock.asleep()
        self.failed = False
        """True after a failure. Then only the last message is sent: we don't know if all robots have stopped."""
        self.player = Player(opened.sink, self._tell, clock.wall)
        self._commands = CommandQueue(opened.sink.preload, clock.now)
        self._is_far = False  # true if its parent is on another machine
        self._is_one_of_many = False  # true if stages on other machines play the same score
        self._deserted = False  # true if its parent was silent, and has sent nothing to play since
        self._held: dict[str | Key, float] = {}  # what people hold at pages, and when it counts as released
        self._unannounced: tuple[Score, int] | None = None  # a score that the player has just been given

    @property
    def _may_move(self) -> bool:
        return self._opened.sink.real and self.player.run.may_move

    def deadline(self, now: float) -> float:
        """The time at which `advance` must be called if nothing arrives."""
        deadline = now if self._commands.is_busy else self.player.deadline(now)
        held = min(self._held.values(), default=math.inf)
        zeros = self._opened.sink.pending_zeros.due if self._opened.sink.pending_zeros else math.inf
        silent = self._parent.deadline if self._may_move else math.inf
        return min(silent, held, zeros, self._commands.due, deadline)

    def wake(self, now: float, asleep: float) -> None:
        """Stop real robots if the machine has slept: nobody knows where they are now, or who is near them."""
        slept, self._asleep = asleep - self._asleep, max(asleep, self._asleep)
        if slept > SLEPT and self._may_move:
            self._halt(f"the machine was asleep for {slept:.0f} s, so all robots were stopped: play again", now)

    def advance(self, now: float, late: float = 0.0) -> None:
        """Do what is due, `late` seconds after the deadline."""
        if self._may_move and self._parent.is_silent(now):
            self._parent_lost(now)
        for what in [what for what, until in self._held.items() if now >= until]:
            self._hold(what, False, now)
        while self._commands.comes_now and (arrival := self._commands.next()):
            self._do(arrival, now)  # first, because setpoints that have been sent can't be taken back
        if not self._commands.is_busy or now >= self.player.deadline(now):
            self.player.advance(now, late)
        if (zeros := self._opened.sink.pending_zeros) and now >= zeros.due:
            zeros.retry(now)
        self._do_next()

    def take(
        self, arrival: Ordered | First | DirectStop | Edge | RawPoses | RawJoints | Alarm | Anchor, now: float
    ) -> None:
        """Handle an arrival. An exception ends the stage, which stops the robots."""
        match arrival:
            case DirectStop():
                self._obey_direct(arrival, now)
            case First():
                self._obey_first(arrival, now)
            case Edge():
                self.player.sense(arrival, now)
            case RawPoses(poses):
                self.player.measure(poses, now)
            case RawJoints():
                self.player.measure_joints(arrival, now)
            case Anchor():
                self.player.take(arrival, now)
            case Alarm(line):
                if self._may_move:
                    self._halt(line, now)
            case Play():
                self._commands.add(replace(arrival, score=_as_played(arrival, self._opened.sink.real)))
                self._do_next()
            case Unreadable() | Lost():
                self._commands.add(arrival)
                self._do_next()
            case _:
                self._take_message(arrival, now)

    def _take_message(self, message: ToStage, now: float) -> None:
        """Handle a message from standard input, or have it wait for earlier ones."""
        if message["type"] == "seen":
            self._obey(message, now)
        elif is_stop(message):
            self._commands.stop()
            self._do(message, now)
        else:
            self._commands.add(message)
            self._do_next()

    def _do_next(self) -> None:
        """Handle as many arrivals from standard input as possible."""
        while (arrival := self._commands.next()) is not None:
            self._do(arrival, self._clock.now())

    def _do(self, arrival: Ordered, now: float) -> None:
        if isinstance(arrival, Play):
            self._load(arrival, now)
        elif isinstance(arrival, Unreadable):
            self._tell({"type": "error", "message": arrival.problem})
            if arrival.is_score:
                self.player.take(STOP, now)
        elif isinstance(arrival, Lost):
            self._tell({"type": "lacks", "generation": arrival.generation})
        elif not (self._deserted and arrival["type"] in VOIDED_BY_STOP):  # its parent will find out, and send all again
            self._obey(arrival, now)

    def _obey_first(self, first: First, now: float) -> None:
        """Obey a message from the channel of stops, or have a pause wait for its time."""
        message = first.message
        self._commands.fence = self._commands.fence.hear(message["type"], first.number)
        if message["type"] == "stop":
            self._commands.forget_pause()
        playing = self.player.run.mode == "playing"
        if not (message["type"] == "pause" and playing and self._commands.pause(message)):
            self._obey(message, now)
        self._do_next()  # an arrival from standard input may have waited for it

    def _obey_direct(self, direct: DirectStop, now: float) -> None:
        """Obey a stop that has come straight here, report it to the parent, and then answer it."""
        name = direct.stop["direct"]
        if not self._commands.fence.has(name):
            self._commands.forget_pause()
            self._commands.fence = self._commands.fence.hear_direct(name)
            self.player.take(direct.stop, now)
            self._tell({"type": "request", "command": {"at": now, **direct.stop}})
        direct.confirm()

    def stop(self) -> None:
        """Send every robot its last zeros, as far as the sink still can. A failure for one does not affect others."""
        clock, player = self._clock, self.player
        end = clock.now() + END_LIMIT  # the parent waits no longer than this
        # In a pause, robots have stopped, and others may move them. But from here on, it must not end by itself.
        last = STOP if player.run.may_move and player.run.mode != "paused" else PAUSE
        with suppress(Exception):
            player.take(last, clock.now())
        while player.sends and (deadline := player.deadline(clock.now())) < end:
            clock.wait_until(deadline)
            with suppress(Exception):
                player.advance(clock.now())

    def _parent_lost(self, now: float) -> None:
        """Stop all robots because the parent is silent."""
        if not self._is_far:
            line = f"Improv was suspended or hung for {SILENCE_LIMIT} s, so all robots were stopped: play again"
            self._halt(line, now, events.Halted(counts=True))
            return
        self._tell({"type": "deserted", "seconds": self._parent.patience})
        self._deserted = True
        self.player.take(STOP, now)
        self._commands.fence = self._commands.fence.lose()

    def _halt(self, line: str, now: float, event: events.Event = HALTED) -> None:
        """Stop all robots, and report why. No message that the parent has sent until now may move them."""
        self.player.take(event, now)
        self._commands.fence = self._commands.fence.lose()
        self._tell({"type": "error", "message": line})

    def _tell(self, message: FromStage) -> None:
        if self.failed:
            return
        self._announce()
        if message["type"] == "transport" and self._deserted:
            message["deserted"] = True
        self._opened.tell(message)

    def _announce(self) -> None:
        """Announce the latest score, unless that has happened: its first velocities come before that."""
        score, self._unannounced = self._unannounced, None
        if score:
            self._opened.announce(*score)

    def _load(self, asked: Play, now: float) -> None:
        load = asked.load
        if self._opened.sink.real and load.get("asleep", math.inf) < self._asleep - SLEPT:
            self._halt("the machine was asleep since somebody asked for this program: play it again", now)
            return
        if load["when"] == "restart":
            self._deserted = False
        elif "here" in load and (self._deserted or self.player.run.mode not in ("playing", "paused")):
            self._tell({"type": "lacks", "generation": load["generation"]})  # it would play alone, from beat 0
            return
        self._is_far = "patience" in load
        self._parent.patience = load.get("patience", SILENCE_LIMIT)
        self._is_one_of_many = "here" in load
        self._unannounced = asked.score, load["generation"]
        at = self._as_of(load.get("at"), now)
        self.player.take(asked, at, min(self._late(load, at), LATEST))
        if self.player.run.is_due:
            self.player.advance(self._clock.now())
        self._announce()

    def _obey(self, message: ToStage, now: float) -> None:
        match message["type"]:
            case "ping":
                self._tell({"type": "pong", "number": message["number"]})
            case "stop":
                self.player.take(message, now)
                if name := message.get("direct", ""):
                    if not self._commands.fence.has(name):
                        self._tell({"type": "obeyed", "direct": name})
                    self._commands.fence = self._commands.fence.settle(name)
            case "held" | "released":
                self._hold(GAMEPAD, message["type"] == "held", now)
            case "key":
                self._hold(Key(message["key"]), message["held"], now)
            case "cue" | "osc_sense" | "force":
                self.player.hear(message, self._as_of(message.get("at"), now))
            case "seen":
                self.player.measure(from_elsewhere(message, self.player.run.score, now), now)
            case "sensed":  # from the stage that leads, like a fault and a decision: report what its robots do, too
                if message["generation"] == self.player.run.generation:
                    self.player.foresee(foreseen(message), now)
                self._tell(message)
            case "decided":
                self._tell(message)
            case "fault":
                self.player.take(message, now)
                self._tell(message)
            case "anchor":
                rate = message["tempo"] / 60
                self.player.take(Anchor(message["at"], message["beat"], rate, message["period"], message["jumps"]), now)
            case "bend":
                self.player.take(message, now)
            case "pressed":
                self.player.take(message, now)
                self._opened.sink.guard(self.player.run.stops.on)
            case "load" | "page":  # the thread that reads makes a `Play` of one, and hands the other to pages
                raise AssertionError(message)
            case _:
                at = self._as_of(message.get("at"), now)
                self.player.take(message, at, self._late(message, at))

    def _hold(self, what: str | Key, held: bool, now: float) -> None:
        """Take a button or a key that somebody holds at a page, or releases, or of which nothing comes anymore."""
        changes = held != (what in self._held)
        if held:
            self._held[what] = now + DEADMAN_LIMIT
        else:
            self._held.pop(what, None)
        if changes:  # pages repeat what is held
            self.player.sense(Edge(what, held, now), now)

    def _as_of(self, at: float | None, now: float) -> float:
        """Return the effective time of a request. Setpoints that have been sent since then can't be taken back."""
        return max(min(now if at is None else at, now), self.player.reached)

    def _late(self, message: Mapping[str, Any], at: float) -> float:
        """Return the seconds since other stages have done the same, which takes effect here at this time."""
        return max(at - message.get("at", at), 0.0) if self._is_one_of_many else 0.0


def _as_played(play: Play, real: bool) -> Score:
    """Return a score as a stage plays it: robots that only stand are not waited for and get no zeros if they are real,
    and simulated ones beside real robots, which lead, keep the limits of these."""
    score = play.score.moving() if real else play.score
    if "entry" in play.load and not real:
        parts = {name: replace(part, profile=beside_robots(part.profile)) for name, part in score.parts.items()}
        score = replace(score, parts=parts)
    return score.on(play.load["here"]) if "here" in play.load else score
