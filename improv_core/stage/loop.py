"""What a stage does with what arrives, and when nothing does. Knows no clock but the one it is given."""

from __future__ import annotations

import math
import queue
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol

from improv_core.score.score import Score
from improv_core.stage.player import Player
from improv_core.stage.protocol import (
    END_LIMIT,
    LOADING_LIMIT,
    SILENCE_LIMIT,
    FromStage,
    Load,
    Stopped,
    ToStage,
)
from improv_core.stage.sinks import Edge, Sink

EARLY = 0.0004
"""Seconds by which a stage with real robots wakes up before a setpoint is due: the system wakes it 0.2 ms late. It
costs about 1 % of a core while something plays."""


@dataclass(frozen=True, slots=True)
class Play:
    """A `load` message whose score has been read."""

    load: Load
    score: Score


@dataclass(frozen=True, slots=True)
class Unreadable:
    """A line that is no message, or has a score that can't be read: why, and whether it was a score."""

    problem: str
    is_score: bool = False


@dataclass(frozen=True, slots=True)
class Reading:
    """A long line has arrived. Until it has been read, pings behind it wait."""


@dataclass(frozen=True, slots=True)
class End:
    """Standard input has ended, or a signal asks the stage to end."""


Arrival = ToStage | Play | Unreadable | Reading | Edge | End
"""What may come in while a stage plays."""


class Inbox(Protocol):
    """Where arrivals wait: inbox.Inbox."""

    def get(self, *, timeout: float | None) -> Arrival:
        """The next arrival. Raises queue.Empty after `timeout` seconds without one (None: never)."""


class Clock(Protocol):
    """The time, in seconds: `now` is monotonic, `wall` is Unix time."""

    def now(self) -> float: ...

    def wall(self) -> float: ...

    def wait_until(self, now: float) -> None:
        """Return at this monotonic time, as exactly as the system can."""


@dataclass(frozen=True, slots=True)
class Opened:
    """A sink, where everything the stage says goes, and who is shown what is to be played."""

    sink: Sink
    tell: Callable[[FromStage], None]
    show: Callable[[Score, int], None] = lambda score, generation: None


def run(opened: Opened, inbox: Inbox, clock: Clock) -> int:
    """Play what arrives until the end. Whatever ends it, robots are told to stop. Exit code 1 after a failure."""
    loop = _Loop(opened, clock)
    last: Stopped = {"type": "stopped"}
    early = EARLY if opened.sink.real else 0.0
    try:
        while True:
            now = clock.now()
            deadline = loop.deadline(now)
            try:
                arrival = inbox.get(timeout=max(deadline - early - now, 0) if deadline < math.inf else None)
            except queue.Empty:
                clock.wait_until(deadline)
                loop.advance(clock.now())
            else:
                if isinstance(arrival, End):
                    return 0
                loop.take(arrival, clock.now())
    except Exception as error:
        last["message"] = one_line(error)
        loop.failed = True
        return 1
    finally:
        loop.stop()
        opened.tell({**last, **loop.player.whereabouts()})
        opened.sink.close()


def one_line(error: Exception) -> str:
    """An exception in words."""
    return " ".join(str(error).split()) or type(error).__name__


class _Loop:
    def __init__(self, opened: Opened, clock: Clock) -> None:
        self._opened = opened
        self._clock = clock
        self.failed = False
        """From then on only the last message is told: that robots stand is not known of one that can't be told."""
        self.player = Player(opened.sink, self._tell, clock.wall)
        self._hangs_from = math.inf  # when the parent, if it has pinged at all, counts as hung

    def deadline(self, now: float) -> float:
        """When `advance` must be called if nothing arrives."""
        deadline = self.player.deadline(now)
        return self._hangs_from if deadline is None else min(deadline, self._hangs_from)

    def advance(self, now: float) -> None:
        """Do what is due."""
        if now >= self._hangs_from:
            self._hangs_from = math.inf
            if self.player.state in ("playing", "waiting"):
                self.player.hush(now)
                what = (
                    f"Improv was halted or hung for {SILENCE_LIMIT} s, so all robots were stopped: save to play again"
                )
                self._tell({"type": "error", "message": what})
        self.player.advance(now)

    def take(self, arrival: ToStage | Play | Unreadable | Reading | Edge, now: float) -> None:
        """Do what is asked for. What goes wrong ends the stage, which stops the robots."""
        pinged = isinstance(arrival, dict) and arrival["type"] == "ping"
        if isinstance(arrival, Edge):
            self.player.sense(arrival, now)
            return
        if self._opened.sink.real and (pinged or self._hangs_from < math.inf):
            self._hangs_from = now + (LOADING_LIMIT if isinstance(arrival, Reading) else SILENCE_LIMIT)
        if isinstance(arrival, Play):
            self._load(arrival, now)
        elif isinstance(arrival, Unreadable):
            self._tell({"type": "error", "message": arrival.problem})
            if arrival.is_score:
                self.player.hush(now)
        elif not isinstance(arrival, Reading):
            self._obey(arrival, now)

    def stop(self) -> None:
        """Send every robot its last zeros, as far as the sink still can: what fails for one is not to harm others."""
        clock, player = self._clock, self.player
        end = clock.now() + END_LIMIT  # nobody waits longer
        if player.state in ("playing", "waiting"):  # else they stand already, and belong to whoever moves them next
            with suppress(Exception):
                player.hush(clock.now())
        while (deadline := player.deadline(clock.now())) is not None and deadline < end:
            clock.wait_until(deadline)
            with suppress(Exception):
                player.advance(clock.now())

    def _tell(self, message: FromStage) -> None:
        if not self.failed:
            self._opened.tell(message)

    def _load(self, asked: Play, now: float) -> None:
        load, score = asked.load, asked.score
        self.player.backend = load["backend"]
        self._opened.show(score, load["generation"])
        at = self._as_of(load.get("at"), now)
        self.player.load(score, load["generation"], load["when"], at, load.get("zero"))

    def _obey(self, message: ToStage, now: float) -> None:
        if message["type"] == "ping":
            self._tell({"type": "pong", "number": message["number"]})
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

    def _as_of(self, at: float | None, now: float) -> float:
        """All stages act as of the time of a request; but what has been sent since can't be taken back."""
        return max(min(now if at is None else at, now), self.player.reached)
