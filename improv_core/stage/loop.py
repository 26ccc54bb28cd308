"""A stage's main loop: handles messages as they arrive, and plays in between. It uses no clock but the one it is
given."""

from __future__ import annotations

import math
import queue
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any, Protocol

from improv_core.ipc.arrivals import Arrival, DirectStop, End, First, Lost, Ordered, Play, Unreadable
from improv_core.plain import one_line
from improv_core.player.player import Player
from improv_core.player.sensing import foreseen
from improv_core.player.separation_monitor import from_elsewhere
from improv_core.player.start_gate import made_of
from improv_core.protocol.commands import VOIDED_BY_STOP, Pause, Stop, is_stop
from improv_core.protocol.limits import DEADMAN_LIMIT, END_LIMIT, MOST_AHEAD, SILENCE_LIMIT
from improv_core.protocol.messages import Decided, FromStage, Sensed, Stopped, ToStage
from improv_core.protocol.output import Alarm, Edge, RawJoints, RawPoses, Sink
from improv_core.protocol.robot_messages import FaultMessage
from improv_core.safety.interlocks import GAMEPAD
from improv_core.safety.parent_heartbeat import Parent
from improv_core.safety.suspend import NOTICED
from improv_core.score.peer_clock import Anchor
from improv_core.score.profiles import beside_robots
from improv_core.score.score import Score
from improv_core.score.senses import RobotSense
from improv_core.score.transport import BEATS_PER_BAR
from improv_core.stage.command_queue import CommandQueue

EARLY = 0.0004
"""Seconds by which a stage with real robots wakes up before a setpoint is due, since the system wakes it 0.2 ms late.
A repeat doesn't need that."""
LATEST = 0.25
"""Seconds by which a score may come late, and still take over at the same beat as in other stages."""


class Inbox(Protocol):
    """A queue of arrivals, such as `urgent_queue.UrgentQueue`."""

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


class ZeroRetries(Protocol):
    """Zeros that robots may not have received (safety/pending_zeros.py)."""

    @property
    def due(self) -> float:
        """The time at which `retry` is due, in monotonic seconds; infinite if no zero is pending."""

    def retry(self, now: float) -> None:
        """Send them again, or find out that robots have received them."""


@dataclass(frozen=True, slots=True)
class OpenedOutput:
    """A sink, and functions that send a message to the parent, announce a score that is about to play, and listen for
    the release of emergency stops that are on."""

    sink: Sink
    tell: Callable[[FromStage], None]
    announce: Callable[[Score, int], None] = lambda score, generation: None
    guard: Callable[[Collection[str]], None] = lambda topics: None
    pending_zeros: ZeroRetries | None = None


def run(opened: OpenedOutput, inbox: Inbox, clock: Clock, parent: Parent) -> int:
    """Play what arrives until the end, and stop the robots whatever ends it. Returns exit code 1 after a failure."""
    loop = Loop(opened, clock, parent)
    last: Stopped = {"type": "stopped"}
    try:
        while True:
            now = clock.now()
            deadline = loop.deadline(now)
            early = EARLY if opened.sink.real and loop.player.is_exact else 0.0
            arrival = None
            try:
                arrival = inbox.get(timeout=max(deadline - early - now, 0) if deadline < math.inf else None)
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
                loop.advance(now)
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
        """True after a failure. Then only the last message is sent, since we don't know whether all robots have
        stopped."""
        self.player = Player(opened.sink, self._tell, clock.wall)
        self._may_move = False  # true if real robots move, or may do so by themselves
        self._commands = CommandQueue(opened.sink.preload, clock.now)
        self._is_far = False  # true if its parent is on another machine
        self._is_one_of_many = False  # true if stages on other machines play the same score
        self._deserted = False  # true if its parent was silent, and has sent nothing to play since
        self._held_until = math.inf  # the time at which a deadman button at the page, if it is held, counts as released
        self._keys: dict[str, float] = {}  # keys of senses that are held, and the times at which they count as released

    def deadline(self, now: float) -> float:
        """The time at which `advance` must be called if nothing arrives."""
        deadline = now if self._commands.is_busy else self.player.deadline(now)
        keys = min(self._keys.values(), default=math.inf)
        zeros = self._opened.pending_zeros.due if self._opened.pending_zeros else math.inf
        silent = self._parent.deadline if self._may_move else math.inf
        playing = math.inf if deadline is None else deadline
        return min(silent, self._held_until, keys, zeros, self._commands.due, playing)

    def wake(self, now: float, asleep: float) -> None:
        """Stop real robots if the machine has slept: nobody knows where they are now, or who is near them."""
        slept, self._asleep = asleep - self._asleep, max(asleep, self._asleep)
        if slept > NOTICED and self._may_move:
            self._halt(f"the machine was asleep for {slept:.0f} s, so all robots were stopped: save to play again", now)

    def advance(self, now: float) -> None:
        """Do everything that is due."""
        if self._may_move and self._parent.is_silent(now):
            self._parent_lost(now)
        if now >= self._held_until:
            self.hold(None, now)
        for key in [key for key, until in self._keys.items() if now >= until]:
            self.hold_key(key, False, now)
        while self._commands.comes_now and (arrival := self._commands.next()):
            self._do(arrival, now)  # first, because setpoints that have been sent can't be taken back
        due = self.player.deadline(now) if self._commands.is_busy else now
        if due is not None and now >= due:
            self.player.advance(now)
        if self._opened.pending_zeros and now >= self._opened.pending_zeros.due:
            self._opened.pending_zeros.retry(now)
        self._do_next()

    def take(
        self, arrival: Ordered | First | DirectStop | Edge | RawPoses | RawJoints | Alarm | Anchor, now: float
    ) -> None:
        """Handle an arrival. An exception ends the stage, which stops the robots."""
        if isinstance(arrival, DirectStop):
            self._obey_direct(arrival, now)
        elif isinstance(arrival, Edge):
            self.player.sense(arrival, now)
        elif isinstance(arrival, RawPoses):
            self.player.measure(arrival.poses, now)
        elif isinstance(arrival, RawJoints):
            self.player.measure_joints(arrival, now)
        elif isinstance(arrival, Anchor):
            self.player.hear_clock(arrival, now)
        elif isinstance(arrival, Alarm):
            if self._may_move:
                self._halt(arrival.message, now)
        elif isinstance(arrival, First):
            message = arrival.message
            self._commands.fence = self._commands.fence.hear(message["type"], arrival.number)
            if message["type"] == "stop":
                self._commands.forget_pause()
                self._settle(message)
            playing = self.player.state == "playing"
            if not (message["type"] == "pause" and playing and self._commands.pause(message)):
                self._obey(message, now)
            self._do_next()  # an arrival from standard input may have waited for it
        elif isinstance(arrival, dict) and arrival["type"] == "seen":  # it doesn't wait for earlier arrivals
            self._obey(arrival, now)
        elif isinstance(arrival, dict) and is_stop(arrival):
            self._commands.stop()
            self._settle(arrival)
            self._do(arrival, now)
        else:
            if isinstance(arrival, Play) and self._opened.sink.real:
                # No robot that only stands is waited for, and none is sent anything.
                here, score = arrival.load.get("here"), arrival.score.moving()
                arrival = replace(arrival, score=score if here is None else score.on(here))
            self._commands.add(arrival)
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
                self.player.stop(now)
        elif isinstance(arrival, Lost):
            self._tell({"type": "lacks", "generation": arrival.generation})
        elif not (self._deserted and arrival["type"] in VOIDED_BY_STOP):  # its parent will find out, and send all again
            self._obey(arrival, now)

    def _obey_direct(self, direct: DirectStop, now: float) -> None:
        """Obey a stop that has come straight here, report it to the parent, and then answer it."""
        name = direct.stop["direct"]
        if not self._commands.fence.has(name):
            self._commands.forget_pause()
            self._commands.fence = self._commands.fence.hear_direct(name)
            self.player.stop(now, direct.stop.get("by"))
            self._tell({"type": "request", "command": {**direct.stop, "at": now}})
        direct.confirm()

    def _settle(self, stop: Stop | Pause) -> None:
        """Note that the parent has sent a stop that may have come straight here, too."""
        if stop["type"] == "stop" and "direct" in stop:
            self._commands.fence = self._commands.fence.settle(stop["direct"])

    def stop(self) -> None:
        """Send every robot its last zeros, as far as the sink still can. A failure for one does not affect others."""
        clock, player = self._clock, self.player
        end = clock.now() + END_LIMIT  # the parent waits no longer than this
        if player.state in ("playing", "waiting"):  # otherwise robots have stopped, and others may move them
            with suppress(Exception):
                player.stop(clock.now())
        while (deadline := player.deadline(clock.now())) is not None and deadline < end:
            clock.wait_until(deadline)
            with suppress(Exception):
                player.advance(clock.now())

    def _parent_lost(self, now: float) -> None:
        """Stop all robots because the parent is silent."""
        if not self._is_far:
            line = f"Improv was suspended or hung for {SILENCE_LIMIT} s, so all robots were stopped: save to play again"
            self._halt(line, now)
            return
        self._tell({"type": "deserted", "seconds": self._parent.patience})
        self._deserted = True
        self.player.stop(now)
        self._commands.fence = self._commands.fence.lose()

    def _halt(self, line: str, now: float) -> None:
        """Stop all robots, and report why. No message that the parent has sent until now may move them."""
        self.player.stop(now)
        self._commands.fence = self._commands.fence.lose()
        self._tell({"type": "error", "message": line})

    def _tell(self, message: FromStage) -> None:
        if self.failed:
            return
        if message["type"] == "transport":
            if self._deserted:
                message["deserted"] = True
            waits = message["state"] == "paused" and "waits_for" in message
            self._may_move = self._opened.sink.real and (message["state"] in ("playing", "waiting") or waits)
        self._opened.tell(message)

    def _load(self, asked: Play, now: float) -> None:
        load, score = asked.load, asked.score
        if self._opened.sink.real and load.get("asleep", math.inf) < self._asleep - NOTICED:
            self._halt("the machine was asleep since somebody asked for this program: save to play it", now)
            return
        if load["when"] == "restart":
            self._deserted = False
        elif "here" in load and (self._deserted or self.player.state not in ("playing", "paused")):
            self._tell({"type": "lacks", "generation": load["generation"]})  # it would play alone, from beat 0
            return
        if "entry" in load and not self._opened.sink.real:  # real robots lead
            parts = {name: replace(part, profile=beside_robots(part.profile)) for name, part in score.parts.items()}
            score = replace(score, parts=parts)
        self._is_far = "patience" in load
        self._parent.patience = load.get("patience", SILENCE_LIMIT)
        if self._opened.sink.real:
            score = score.moving()  # robots that only stand are not waited for, and get no zeros
        self._is_one_of_many = "here" in load
        if "here" in load:
            score = score.on(load["here"])
        self.player.backend = load["backend"]
        self._opened.announce(score, load["generation"])
        at = self._as_of(load.get("at"), now)
        not_before = load.get("at", now) if load["when"] != "restart" else now
        bar = load.get("beats_per_bar", BEATS_PER_BAR)
        senses = [foreseen(each) for each in load["senses"]] if "senses" in load else None
        rest = (
            load.get("entry"),
            bar,
            senses,
            load.get("stops"),
            load.get("anyway", False),
            made_of(load.get("arming"), shared=self._is_one_of_many),
            min(not_before, now + MOST_AHEAD),
            min(self.late(load, at), LATEST),
            load.get("by"),
        )
        self.player.load(score, load["generation"], load["when"], at, *rest)

    def _obey(self, message: ToStage, now: float) -> None:
        if message["type"] == "ping":
            self._tell({"type": "pong", "number": message["number"]})
            return
        if message["type"] == "sensed" or message["type"] == "decided" or message["type"] == "fault":
            self._follow(message, now)
            return
        if message["type"] == "seen":
            self.player.measure(from_elsewhere(message, self.player.score, now), now)
            return
        if message["type"] == "anchor":
            heard = Anchor(message["at"], message["beat"], message["tempo"] / 60, message["period"], message["jumps"])
            self.player.hear_clock(heard, now)
            return
        if message["type"] == "bend":
            self.player.bend(message["pace"], message["beat"], message["at"], now)
            return
        if message["type"] == "pressed":
            self.player.stops = self.player.stops.told(message)
            self._opened.guard(self.player.stops.on)
            return
        assert message["type"] != "page"  # the thread that reads hands it to the pages
        OBEYED[message["type"]](self, message, self._as_of(message.get("at"), now), now)

    def obey_stop(self, message: Stop, now: float) -> None:
        """Stop all robots, and confirm that if a page has sent the stop."""
        self.player.stop(now, message.get("by"))
        if "mark" in message:
            self._tell({"type": "obeyed", "mark": message["mark"], "waits_for": []})

    def hold(self, held: bool | None, now: float) -> None:
        """Hold or release the deadman button at the page; None if it has fallen silent."""
        self._held_until = now + DEADMAN_LIMIT if held else math.inf
        self.player.sense(Edge(GAMEPAD, held, now), now)

    def hold_key(self, key: str, held: bool, now: float) -> None:
        """Hold or release a key of a sense, or note that it has fallen silent."""
        changes = held != (key in self._keys)
        if held:
            self._keys[key] = now + DEADMAN_LIMIT
        else:
            self._keys.pop(key, None)
        if changes:  # pages repeat a key that is held
            self.player.hold_key(key, held, now)

    def _follow(self, message: Sensed | Decided | FaultMessage, now: float) -> None:
        """Do what real robots do, by the report of the leading stage, and report it, too."""
        if message["type"] == "sensed" and message["generation"] == self.player.generation:
            self.player.foresee(foreseen(message), now)
        elif message["type"] == "fault" and message["response"] == "stand" and not message["over"]:
            self.player.stand(message["robot"], now)
        self._tell(message)

    def _as_of(self, at: float | None, now: float) -> float:
        """Return the effective time of a request. Setpoints that have been sent since then can't be taken back."""
        return max(min(now if at is None else at, now), self.player.reached)

    def late(self, message: Mapping[str, Any], at: float) -> float:
        """Return the seconds since other stages have done the same, which takes effect here at this time."""
        return max(at - message.get("at", at), 0.0) if self._is_one_of_many else 0.0


OBEYED: Mapping[str, Callable[[Loop, Any, float, float], None]] = {
    "stop": lambda loop, message, at, now: loop.obey_stop(message, now),
    "pause": lambda loop, _, at, now: loop.player.pause(at),
    "resume": lambda loop, message, at, now: loop.player.resume(at, late=loop.late(message, at), by=message.get("by")),
    "anyway": lambda loop, message, at, now: loop.player.resume(at, anyway=True, late=loop.late(message, at)),
    "seek": lambda loop, message, at, now: loop.player.seek(message["beat"], at, loop.late(message, at)),
    "speed": lambda loop, message, at, now: loop.player.set_speed(message["factor"], at, loop.late(message, at)),
    "silence": lambda loop, message, at, now: loop.player.set_silent(message["muted"], message["soloed"], at),
    "held": lambda loop, _, at, now: loop.hold(True, now),
    "released": lambda loop, _, at, now: loop.hold(False, now),
    "cue": lambda loop, _, at, now: loop.player.cue(at),
    "key": lambda loop, message, at, now: loop.hold_key(message["key"], message["held"], now),
    "osc_sense": lambda loop, message, at, now: loop.player.hear_osc(
        message["name"], message["robot"], message["value"], at
    ),
    "force": lambda loop, message, at, now: loop.player.force(
        RobotSense(message["robot"], message["sense"]), message["value"], at
    ),
}
"""The reaction of a stage to each command. `at` is the time at which it takes effect, `now` the present, in seconds."""
