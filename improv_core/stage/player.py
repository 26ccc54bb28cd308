"""Plays scores: what each robot is told, and exactly when. Knows no clock but the times it is given.

Two kinds of time: `now` is the clock's, in seconds; performance time counts from beat 0 of the latest restart.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from fractions import Fraction
from heapq import heappop, heappush, heapreplace
from typing import Any, NamedTuple

from improv_core.motion import STILL, Twist
from improv_core.movement import ENDLESS, walk
from improv_core.score import Part, Score, twist
from improv_core.stage.sinks import Sink

PATIENCE = 5.0
"""Seconds to wait for a new robot's listener before beat 0: ROS 2 discovery took up to 2.64 s where it was measured on
a quiet machine, and more than 3 s on a busy one."""
LOOK_AGAIN = 0.01
"""Seconds between two looks for listeners."""
LAST_ZEROS = 3
"""How many zeros end a robot's motion: one may be lost, and a steady stream of them would fight other publishers."""
SHORTEST = Fraction(1, 1000)
"""Seconds. Changes that come faster than this are sampled at this distance, so that no program can swamp a robot."""

EMPTY = Score(Fraction(60), {})


class Command(NamedTuple):
    """A robot's velocity, from `at` seconds on."""

    at: float
    twist: Twist


@dataclass(frozen=True, slots=True)
class Swap:
    """A score that takes over at a performance time, at once if that is None."""

    score: Score
    generation: int
    at: float


def commands(part: Part, tempo: Fraction) -> Iterator[Command]:
    """All a robot is told: every change at its time, repeated in between at the profile's rate, zeros at the end."""
    period = 1 / part.profile.command_rate
    shortest = SHORTEST * tempo / 60
    seconds = 60 / tempo
    moments = walk(part.movement, merge=True)
    while moment := next(moments, None):
        end = moment.start + moment.duration
        if moment.duration < shortest:
            end = moment.start + shortest
            if end >= part.movement.duration:
                end = Fraction(part.movement.duration)
            moments = walk(part.movement, end, merge=True)
        moving = twist(moment.velocity, part.profile, tempo)
        yield from _held(moving, float(moment.start * seconds), float(end * seconds), period)
    yield from zeros(float(part.movement.duration * seconds), period)


def zeros(start: float, period: float) -> Iterator[Command]:
    """The short burst that stops a robot."""
    return (Command(start + count * period, STILL) for count in range(LAST_ZEROS))


def _held(moving: Twist, start: float, end: float, period: float) -> Iterator[Command]:
    # Each time is counted from the start, never added up: no error grows however long the velocity is held.
    count = 0
    while (at := start + count * period) < end:
        yield Command(at, moving)
        count += 1


class Player:
    """Plays one score at a time on a sink, and tells what it does in transport messages (see docs/protocol.md)."""

    def __init__(self, sink: Sink, tell: Callable[[dict[str, Any]], None], wall: Callable[[], float]) -> None:
        self._sink = sink
        self._tell = tell
        self._wall = wall
        self._score = EMPTY
        self.backend = sink.name
        """What everything plays on, in words, for those who watch."""
        self._generation = 0
        self._state = "stopped"
        self._zero = 0.0  # the clock's time of performance time 0
        self._began = 0.0  # performance time of beat 0 of this score
        self._queue: list[tuple[float, str, Twist, Iterator[Command], float]] = []
        self._met: dict[str, float] = {}  # when each robot was first prepared
        self._next: Swap | None = None
        self._start_poses: dict[str, Any] = {}

    @property
    def state(self) -> str:
        """stopped, waiting (for listeners), playing, or ended."""
        return self._state

    def load(self, score: Score, generation: int, when: str, now: float, zero: float | None = None) -> None:
        """Play a score: `restart` from beat 0 with robots at their start, or take over `now`, at the `beat` or `end`.

        `zero` is the clock's time of beat 0 where another stage has set it.
        """
        at = self._switch_time(when, now) if self._state == "playing" else None
        if at is None:
            self._restart(Swap(score, generation, 0.0), now, zero)
        else:
            self._next = Swap(score, generation, at)
            self.advance(now)

    def hush(self, now: float) -> None:
        """Stop every robot at once. If one can't be told, the others still are; what went wrong first is raised."""
        performed = now - self._zero
        self._next = None
        self._queue = []
        problems = []
        for robot, part in self._score.parts.items():
            burst = zeros(performed, 1 / part.profile.command_rate)
            try:
                self._sink.send(robot, STILL, next(burst).at)
            except Exception as problem:  # whatever a sink's library raises
                problems.append(problem)
            self._enqueue(robot, burst, 0.0)
        if problems:
            raise problems[0]
        self._sink.advance(performed)
        self._state = "stopped"
        self._tell_transport(now)

    def advance(self, now: float) -> None:
        """Send everything that is due."""
        if self._state == "waiting":
            self._look_for_listeners(now)
            if self._state == "waiting":
                return
        performed = self._performed(now)
        if self._next and performed >= self._next.at:
            swap, self._next = self._next, None
            # What the old score has to say at that very moment, the new one says instead.
            self._send_due(math.nextafter(swap.at, -math.inf))
            self._take_over(swap, now)
        end = self._end()
        if self._state == "playing" and performed >= end:
            self._send_due(end)
            self._state = "ended"
            self._tell_transport(now)
        self._send_due(performed)

    def deadline(self, now: float) -> float | None:
        """When `advance` must be called next, by the clock; None if nothing is to come."""
        if self._state == "waiting":
            return now + LOOK_AGAIN
        due = self._due()
        if due == math.inf:
            return None
        return min(due + self._zero, now + self._sink.period) if self._sink.period else due + self._zero

    def _due(self) -> float:
        """The performance time of what comes next."""
        queued = self._queue[0][0] if self._queue else math.inf
        swap = self._next.at if self._next else math.inf
        end = self._end() if self._state == "playing" else math.inf
        return min(queued, swap, end)

    def _performed(self, now: float) -> float:
        """Performance time by the clock; never a rounding error before what is due by the clock."""
        due = self._due()
        return max(now - self._zero, due) if due + self._zero <= now else now - self._zero

    def _switch_time(self, when: str, now: float) -> float | None:
        """The performance time at which a new score takes over; None for a restart."""
        performed = max(now - self._zero, self._began)
        if when == "now":
            return performed
        if when == "end" and self._end() != math.inf:
            return self._end()
        if when in ("beat", "end"):
            beat = float(60 / self._score.tempo)
            return self._began + math.ceil((performed - self._began) / beat) * beat
        return None

    def _restart(self, swap: Swap, now: float, zero: float | None) -> None:
        leaving = {name: part for name, part in self._score.parts.items() if name not in swap.score.parts}
        self._queue, self._next = [], None
        for robot in leaving:
            self._sink.send(robot, STILL, now - self._zero)
        self._sink.prepare(swap.score.parts, True)
        self._start_poses = _as_json(self._sink.poses())
        self._zero, self._began = zero if zero is not None else now, 0.0
        self._score, self._generation = swap.score, swap.generation
        for robot in swap.score.parts:
            self._met.setdefault(robot, now)
        for robot, part in leaving.items():
            self._enqueue(robot, zeros(0.0, 1 / part.profile.command_rate), 0.0)
        self._state = "waiting"
        if zero is not None:
            self._begin(now)
            return
        self._look_for_listeners(now)
        if self._state == "waiting":
            self._tell_transport(now)

    def _look_for_listeners(self, now: float) -> None:
        missing = self._sink.missing()
        if missing and any(now < self._met[robot] + PATIENCE for robot in missing):
            return
        for problem in missing.values():
            self._tell({"type": "warning", "message": problem})
        self._zero = now
        self._begin(now)

    def _begin(self, now: float) -> None:
        self._state = "playing"
        for robot, part in self._score.parts.items():
            self._enqueue(robot, commands(part, self._score.tempo), 0.0)
        self._tell_transport(now)
        self.advance(now)

    def _take_over(self, swap: Swap, now: float) -> None:
        old = self._score
        self._sink.prepare(swap.score.parts, False)
        self._score, self._generation, self._began = swap.score, swap.generation, swap.at
        self._queue = []
        for robot, part in swap.score.parts.items():
            self._met.setdefault(robot, now)
            self._enqueue(robot, commands(part, swap.score.tempo), swap.at)
        for robot, part in old.parts.items():
            if robot not in swap.score.parts:
                self._enqueue(robot, zeros(0.0, 1 / part.profile.command_rate), swap.at)
        for problem in self._sink.missing().values():
            self._tell({"type": "warning", "message": problem})
        self._tell_transport(now)

    def _end(self) -> float:
        """The performance time at which the longest part ends."""
        return self._began + self._score.seconds(self._score.beats)

    def _enqueue(self, robot: str, told: Iterator[Command], offset: float) -> None:
        first = next(told, None)
        if first:
            heappush(self._queue, (first.at + offset, robot, first.twist, told, offset))

    def _send_due(self, performed: float) -> None:
        queue = self._queue
        while queue and queue[0][0] <= performed:
            at, robot, moving, told, offset = queue[0]
            self._sink.send(robot, moving, at)
            following = next(told, None)
            if following:
                heapreplace(queue, (following.at + offset, robot, following.twist, told, offset))
            else:
                heappop(queue)
        self._sink.advance(performed)

    def _tell_transport(self, now: float) -> None:
        beats = self._score.beats
        seconds_since_beat_0 = now - self._zero - self._began
        beat = max(seconds_since_beat_0 * float(self._score.tempo) / 60, 0.0) if self._state != "waiting" else 0.0
        poses = _as_json(self._sink.poses())
        self._tell(
            {
                "type": "transport",
                "generation": self._generation,
                "state": self._state,
                "backend": self.backend,
                "tempo": float(self._score.tempo),
                "beats": None if beats == ENDLESS else float(beats),
                "beat": beat if beats == ENDLESS else min(beat, float(beats)),
                "monotonic": now,
                "wall": self._wall(),
                **({"start": self._start_poses, "poses": poses} if poses else {}),
            }
        )


def _as_json(poses: Mapping[str, Any]) -> dict[str, Any]:
    return {robot: asdict(pose) for robot, pose in poses.items()}
