"""The stage's side of the process that publishes the forecast (see process.py)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

from improv_core.ipc.child import Policy
from improv_core.ipc.helper import Helper
from improv_core.plain import message as in_plain_text
from improv_core.protocol.helper_messages import FromPublisher, Health, ToPublisher
from improv_core.protocol.limits import helper_command
from improv_core.protocol.messages import FromStage
from improv_core.score.score import Score
from improv_core.score.score_json import RowsWritten, to_json

HEALTH_PERIOD = 1.0
"""Seconds between two reports of how well commands reach robots; REP 107 has diagnostics once a second."""
MEASURED_PERIOD = 1.0
"""Seconds between two reports of a robot's pose. They align its odometry's frame with the world of the score."""
END_LIMIT = 2.0
"""Seconds that it may take to exit when the stage ends."""
POLICY = Policy(20.0)
"""Allows 20 seconds to exit while the stage keeps running, about as long as a killed process stays in the graph."""


class PublisherClient:
    """Has another process publish the forecast while a score asks for that. A thread of its own writes to it.

    Nothing waits for that process. If it fails, `problem` says so, and the next score that asks for it starts another.
    """

    def __init__(self, node: str, arguments: Sequence[str], clock: Callable[[], float]) -> None:
        self._command = helper_command("outputs.ros.publisher.process", node, *arguments)
        self._clock = clock
        self._due = 0.0  # when the next report of health is due
        self._measured: dict[str, float] = {}  # when each robot's next pose is due
        self._process: _Process | None = None
        self._leaving: list[Helper] = []
        self.health = _CommandStats()

    @property
    def problem(self) -> str | None:
        return self._process.problem if self._process else None

    def take(self, score: Score, generation: int) -> None:
        """Start, keep, or end the process, as a new score asks."""
        if self._process and (self._process.problem or not score.publish):
            self._process.helper.close()
            self._leaving = [each for each in [*self._leaving, self._process.helper] if each.is_alive]
            self._process = None
        if score.publish:
            self._process = self._process or _Process(self._command)
            self._process.play(score, generation)

    def show(self, message: FromStage) -> None:
        """Pass on a message of the stage, but only one measured pose per `MEASURED_PERIOD`."""
        if not self._process:
            return
        if message["type"] == "measured":
            now = self._clock()
            if any(now >= self._measured.get(robot, 0.0) for robot in message["robots"]):
                self._measured.update(dict.fromkeys(message["robots"], now + MEASURED_PERIOD))
                self._process.helper.put(message)
        elif (
            message["type"] == "transport"
            or message["type"] == "sensed"
            or message["type"] == "warning"
            or message["type"] == "error"
            or message["type"] == "fault"
        ):
            self._process.helper.put(message)

    def report(self) -> None:
        """Report how well commands reach robots, if that is due."""
        if self._process and (now := self._clock()) >= self._due:
            self._due = now + HEALTH_PERIOD
            self._process.helper.put(self.health.taken())

    def close(self) -> None:
        for process in self._leaving:
            process.kill()
        if self._process:
            self._process.helper.close()
            self._process.helper.wait(END_LIMIT)


@dataclass(slots=True)
class _CommandStats:
    """Facts about commands, collected while they are sent."""

    zero: float | None = None
    """The clock's time at performance time 0, while a score plays."""
    _late: float = 0.0
    _late_robots: dict[str, float] = field(default_factory=dict)
    _missing: dict[str, str] = field(default_factory=dict)
    _clipped: set[str] = field(default_factory=set)

    def sent(self, robot: str, at: float, now: float, clipped: bool) -> None:
        """Note that a velocity due at the performance time `at` was sent."""
        if clipped:
            self._clipped.add(robot)
        late = 0.0 if self.zero is None else now - self.zero - at
        self._late = max(self._late, late)
        if late > 0:
            self._late_robots[robot] = max(self._late_robots.get(robot, 0.0), late)

    def take_late(self) -> Mapping[str, float]:
        """Return the largest lateness of each late robot's commands since the last call, in seconds."""
        late, self._late_robots = self._late_robots, {}
        return late

    def asked(self, robots: Collection[str], missing: dict[str, str]) -> None:
        """Note which of the robots that were checked can't be reached; the line is empty if they soon can."""
        for robot in robots:
            if missing.get(robot):
                self._missing[robot] = missing[robot]
            else:
                self._missing.pop(robot, None)

    def keep(self, robots: Collection[str]) -> None:
        """Forget all other robots."""
        for robot in self._missing.keys() - robots:
            del self._missing[robot]

    def taken(self) -> Health:
        """Return everything since the last call."""
        late, clipped, self._late, self._clipped = self._late, self._clipped, 0.0, set()
        return {"type": "health", "late": late, "missing": dict(self._missing), "clipped": sorted(clipped)}


class _Process:
    """The process, its scores, and the problem with it."""

    def __init__(self, command: Sequence[str]) -> None:
        self.problem: str | None = None
        self._written = RowsWritten()  # belongs to the thread that writes
        self.helper = Helper(command, POLICY, FromPublisher, self._hear, self._fail)

    def play(self, score: Score, generation: int) -> None:
        """Have it publish a score, which takes long to convert."""
        self.helper.put(lambda: self._plays(score, generation))

    def _plays(self, score: Score, generation: int) -> ToPublisher:
        self._written = self._written.renewed()
        return {"type": "plays", "generation": generation, "score": to_json(score, self._written)}

    def _hear(self, message: FromPublisher) -> None:
        self._fail(f"has ended: {message['message']}")

    def _fail(self, why: str) -> None:
        line = f"the process that publishes the dance {why or 'has ended: it was killed'}"
        self.problem = self.problem or in_plain_text(" ".join(f"{line}: the next play starts another one".split()))
