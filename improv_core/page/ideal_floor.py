"""The floor of a page without a simulator: robots stand where their score has them. Standard library only."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from improv_core.preview.forecast import Forecast
from improv_core.protocol.commands import is_muted
from improv_core.protocol.drawn import Snapshot
from improv_core.protocol.messages import Sensed, TransportMessage
from improv_core.score.motion import Pose
from improv_core.score.score import Score

AHEAD = 2.0
"""Seconds that are computed at a time."""


class IdealFloor:
    """Follows the stage of real robots: `add_score` gets each score before it plays, and `take` and `sense` the stage's
    messages.

    Any thread may call it. `clock` returns the monotonic time in seconds.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._forecast = Forecast()
        self._lock = threading.Lock()
        self._due = 0.0  # the time at which the next poses have to be computed
        self._places: dict[str, Pose] = {}  # the latest pose of each robot
        self._jumps = 0

    def add_score(self, score: Score, generation: int) -> None:
        with self._lock:
            self._forecast.add_score(score, generation)

    def knows(self, generation: int) -> bool:
        return self._forecast.knows(generation)

    def take(self, message: TransportMessage) -> Score:
        """Return the score of a message, with the beats and the poses at which its parts began."""
        with self._lock:
            self._forecast.take(message)
            self._due = 0.0
            self._jumps += 1
            assert self._forecast.score
            return self._forecast.score

    def sense(self, message: Sensed) -> None:
        """Take what a robot senses: it may decide what the robot plays."""
        with self._lock:
            self._forecast.take(message)
            self._due = 0.0

    def snapshot(self) -> Snapshot:
        """Return where the robots ideally are now. A muted robot stays where it was."""
        with self._lock:
            forecast, now = self._forecast, self._clock()
            score, transport = forecast.score, forecast.transport
            if not score or not transport:
                return Snapshot()
            if now >= self._due:
                forecast.compute(now, 2 * AHEAD)
                self._due = now + AHEAD
            places = {robot: self._place(robot, transport, now) for robot in score.parts}
            self._places = {robot: pose for robot, pose in places.items() if pose}
            radii = {robot: score.parts[robot].profile.radius for robot in self._places}
            passed = max(now - transport["monotonic"], 0.0) if forecast.is_moving else 0.0
            return Snapshot(transport["performed"] + passed, self._jumps, self._places, radii)

    def _place(self, robot: str, transport: TransportMessage, now: float) -> Pose | None:
        if robot in self._places and is_muted(robot, transport["muted"], transport["soloed"]):
            return self._places[robot]
        return self._forecast.robot_in_world(robot, now).pose or self._places.get(robot)
