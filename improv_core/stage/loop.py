"""A stage's main loop: handles messages as they arrive and plays in between. It only uses the clock it is given."""

from __future__ import annotations

import math
import queue
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Protocol

from improv_core.plain import message as in_plain_text
from improv_core.score.profiles import beside_robots
from improv_core.score.score import Score
from improv_core.score.senses import RobotSense
from improv_core.score.transport import BEATS_PER_BAR
from improv_core.stage.interlocks import GAMEPAD
from improv_core.stage.player import Player
from improv_core.stage.protocol import (
    DEADMAN_LIMIT,
    END_LIMIT,
    LOADING_LIMIT,
    SILENCE_LIMIT,
    Decided,
    FromStage,
    Load,
    Sensed,
    Stopped,
    ToPages,
    ToStage,
)
from improv_core.stage.sensing import foreseen
from improv_core.stage.sinks import Edge, RawPoses, Sink

EARLY = 0.0004
"""Seconds by which a stage with real robots wakes up before a setpoint is due, since the system wakes it 0.2 ms late.
A repeat doesn't need that."""


@dataclass(frozen=True, slots=True)
class Play:
    """A `load` message whose score has been read."""

    load: Load
    score: Score


@dataclass(frozen=True, slots=True)
class Unreadable:
    """A line that is not a valid message, or whose score can't be read: why, and whether it was a score."""

    problem: str
    is_score: bool = False


@dataclass(frozen=True, slots=True)
class Lost:
    """A score of this generation that builds on one that has not been read."""

    generation: int


@dataclass(frozen=True, slots=True)
class Reading:
    """A long line is arriving. Pings after it wait until it has been read."""


@dataclass(frozen=True, slots=True)
class End:
    """Standard input has ended or, because of a problem, can't be read; or a signal asks the stage to end."""

    problem: str = ""


Arrival = ToStage | Play | Unreadable | Lost | Reading | Edge | RawPoses | End
"""What may arrive while a stage plays."""


class Inbox(Protocol):
    """A queue of arrivals, such as `urgent_queue.UrgentQueue`."""

    def get(self, *, timeout: float | None) -> Arrival:
        """The next arrival. Raises queue.Empty after `timeout` seconds without one (None: never)."""


class Clock(Protocol):
    """The time, in seconds: `now` is monotonic, `wall` is Unix time."""

    def now(self) -> float: ...

    def wall(self) -> float: ...

    def wait_until(self, now: float) -> None:
        """Return at this monotonic time, as precisely as the system can."""


@dataclass(frozen=True, slots=True)
class Opened:
    """A sink, and functions that send a message to the parent, show a score on pages, and pass on what is for them."""

    sink: Sink
    tell: Callable[[FromStage], None]
    show: Callable[[Score, int], None] = lambda score, generation: None
    present: Callable[[ToPages], None] = lambda message: None


def run(opened: Opened, inbox: Inbox, clock: Clock) -> int:
    """Play what arrives until the end. Robots are stopped, whatever ends it. Returns exit code 1 after a failure."""
    loop = _Loop(opened, clock)
    last: Stopped = {"type": "stopped"}
    try:
        while True:
            now = clock.now()
            deadline = loop.deadline(now)
            early = EARLY if opened.sink.real and loop.player.is_exact else 0.0
            try:
                arrival = inbox.get(timeout=max(deadline - early - now, 0) if deadline < math.inf else None)
            except queue.Empty:
                clock.wait_until(deadline)
            else:
                if isinstance(arrival, End):
                    if not arrival.problem:
                        return 0
                    last["message"] = arrival.problem
                    return 1
                loop.take(arrival, clock.now())
            if (now := clock.now()) >= deadline:  # also if another arrival waits: robots must not wait for a flood
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


def one_line(error: BaseException) -> str:
    """An exception as one printable line of text."""
    return in_plain_text(" ".join(str(error).split()) or type(error).__name__)


class _Loop:
    def __init__(self, opened: Opened, clock: Clock) -> None:
        self._opened = opened
        self._clock = clock
        self.failed = False
        """From then on only the last message is sent, since we don't know whether all robots have stopped."""
        self.player = Player(opened.sink, self._tell, clock.wall)
        self._hangs_from = math.inf  # when the parent counts as hung, if it has ever pinged
        self._held_until = math.inf  # when a deadman button at the page, if it is held, counts as released
        self._keys: dict[str, float] = {}  # keys of senses that are held, and when they count as let go
        self._shown = 0, 0  # the generation and scene that are shown with the beats at which their parts begin

    def deadline(self, now: float) -> float:
        """The time at which `advance` must be called if nothing arrives."""
        deadline = self.player.deadline(now)
        keys = min(self._keys.values(), default=math.inf)
        return min(self._hangs_from, self._held_until, keys, math.inf if deadline is None else deadline)

    def advance(self, now: float) -> None:
        """Do everything that is due."""
        if now >= self._hangs_from:
            self._hangs_from = math.inf
            if self.player.state in ("playing", "waiting"):
                self.player.hush(now)
                stalled = f"Improv was suspended or hung for {SILENCE_LIMIT} s"
                line = f"{stalled}, so all robots were stopped: save to play again"
                self._tell({"type": "error", "message": line})
        if now >= self._held_until:
            self._hold(None, now)
        for key in [key for key, until in self._keys.items() if now >= until]:
            self._hold_key(key, False, now)
        self.player.advance(now)

    def take(self, arrival: ToStage | Play | Unreadable | Lost | Reading | Edge | RawPoses, now: float) -> None:
        """Handle an arrival. An exception ends the stage, which stops the robots."""
        pinged = isinstance(arrival, dict) and arrival["type"] == "ping"
        if isinstance(arrival, Edge):
            self.player.sense(arrival, now)
            return
        if isinstance(arrival, RawPoses):
            self.player.measure(arrival.poses, now)
            return
        if self._opened.sink.real and (pinged or self._hangs_from < math.inf):
            self._hangs_from = now + (LOADING_LIMIT if isinstance(arrival, Reading) else SILENCE_LIMIT)
        if isinstance(arrival, Play):
            self._load(arrival, now)
        elif isinstance(arrival, Unreadable):
            self._tell({"type": "error", "message": arrival.problem})
            if arrival.is_score:
                self.player.hush(now)
        elif isinstance(arrival, Lost):
            self._tell({"type": "lacks", "generation": arrival.generation})
        elif not isinstance(arrival, Reading):
            self._obey(arrival, now)

    def stop(self) -> None:
        """Send every robot its last zeros, as far as the sink still can. A failure for one does not affect others."""
        clock, player = self._clock, self.player
        end = clock.now() + END_LIMIT  # the parent waits no longer than this
        if player.state in ("playing", "waiting"):  # otherwise they have stopped and may be moved by others
            with suppress(Exception):
                player.hush(clock.now())
        while (deadline := player.deadline(clock.now())) is not None and deadline < end:
            clock.wait_until(deadline)
            with suppress(Exception):
                player.advance(clock.now())

    def _tell(self, message: FromStage) -> None:
        if self.failed:
            return
        if message["type"] == "transport":
            shown = message["generation"], message.get("scene", {"index": 0})["index"]
            if "begins" in message and shown != self._shown:
                self._shown = shown
                self._opened.show(self.player.score, message["generation"])  # now it is known when its parts began
        self._opened.tell(message)

    def _load(self, asked: Play, now: float) -> None:
        load, score = asked.load, asked.score
        if "entry" in load:  # real robots lead
            parts = {name: replace(part, profile=beside_robots(part.profile)) for name, part in score.parts.items()}
            score = replace(score, parts=parts)
        self.player.backend = load["backend"]
        self._opened.show(score, load["generation"])
        at = self._as_of(load.get("at"), now)
        bar = load.get("beats_per_bar", BEATS_PER_BAR)
        senses = [foreseen(each) for each in load["senses"]] if "senses" in load else None
        self.player.load(score, load["generation"], load["when"], at, load.get("entry"), bar, senses)

    def _obey(self, message: ToStage, now: float) -> None:
        if message["type"] == "ping":
            self._tell({"type": "pong", "number": message["number"]})
            return
        if (
            message["type"] == "program"
            or message["type"] == "source"
            or message["type"] == "answer"
            or message["type"] == "measured"
        ):
            self._opened.present(message)
            return
        if message["type"] == "sensed" or message["type"] == "decided":
            self._follow(message, now)
            return
        player, at = self.player, self._as_of(message.get("at"), now)
        if message["type"] == "hush":
            player.hush(now)
        elif message["type"] == "pause":
            player.pause(at)
        elif message["type"] == "resume":
            player.resume(at)
        elif message["type"] == "seek":
            player.seek(message["beat"], at)
        elif message["type"] == "speed":
            player.set_speed(message["factor"], at)
        elif message["type"] == "silence":
            player.set_silent(message["muted"], message["soloed"], at)
        elif message["type"] == "held" or message["type"] == "released":
            self._hold(message["type"] == "held", now)
        elif message["type"] == "cue":
            player.cue(at)
        elif message["type"] == "key":
            self._hold_key(message["key"], message["held"], now)
        elif message["type"] == "force":
            player.force(RobotSense(message["robot"], message["sense"]), message["value"], at)

    def _hold(self, held: bool | None, now: float) -> None:
        """The deadman button at the page is held or released; None if nothing is heard of it."""
        self._held_until = now + DEADMAN_LIMIT if held else math.inf
        self.player.sense(Edge(GAMEPAD, held, now), now)

    def _hold_key(self, key: str, held: bool, now: float) -> None:
        """A key is held for a sense, or let go, or nothing more is heard of it."""
        changes = held != (key in self._keys)
        if held:
            self._keys[key] = now + DEADMAN_LIMIT
        else:
            self._keys.pop(key, None)
        if changes:  # pages repeat a key that is held
            self.player.hold_key(key, held, now)

    def _follow(self, message: Sensed | Decided, now: float) -> None:
        """The stage that leads says what real robots sense or decide: do the same, and show it."""
        if message["type"] == "sensed" and message["generation"] == self.player.generation:
            self.player.foresee(foreseen(message), now)
        self._tell(message)

    def _as_of(self, at: float | None, now: float) -> float:
        """The effective time of a request. Setpoints that have been sent since then can't be taken back."""
        return max(min(now if at is None else at, now), self.player.reached)
