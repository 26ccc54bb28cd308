"""Results of the latest program that played in a terminal: its end, and where its robots went."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from improv_core.program.errors import Errors
from improv_core.program.report import outcome
from improv_core.protocol.messages import MisplacedRobot, Poses, State, TransportMessage
from improv_core.protocol.robot_messages import Measured, MeasuredRobot
from improv_core.score.motion import Pose
from improv_core.score.score import Score


class Results:
    """The results, according to the messages of stages."""

    def __init__(self) -> None:
        self.measured: dict[str, tuple[MeasuredRobot, MeasuredRobot]] = {}
        """First and latest pose of robots since beat 0, if they are measured."""
        self.misplaced: Mapping[str, MisplacedRobot] = {}
        """Robots that aren't in their places."""
        self.errors = Errors()
        self._transports: dict[bool, TransportMessage] = {}  # the latest of each stage, by whether it leads
        self._poses: Poses = {}  # from the stage that has them

    @property
    def state(self) -> State | None:
        """The state of the program, as the leading stage reports it; None if nothing has played."""
        return self._transports[True]["state"] if True in self._transports else None

    @property
    def is_over(self) -> bool:
        """True if no stage plays."""
        return not any(each["state"] == "playing" for each in self._transports.values())

    def follow(self, transport: TransportMessage, leads: bool) -> None:
        """Note a message of a stage. With a restart, all is forgotten that was measured before."""
        before = self._transports.get(True)
        if leads and (not before or transport["restarted"] != before["restarted"]):
            self.errors, self.measured = Errors(), {}
        self._transports[leads] = transport
        self.keep_poses(transport)

    def keep_poses(self, message: Poses) -> None:
        """Keep the poses in a message, if it has some; the start poses stay unless it has others."""
        if "poses" in message:
            self._poses = {**self._poses, **message}

    def measure(self, message: Measured) -> None:
        """Note measured poses."""
        self.errors.take(message)
        for robot, each in message["robots"].items():
            self.measured[robot] = self.measured.get(robot, (each, each))[0], each

    def simulated_move(self, robot: str) -> tuple[Pose, Pose] | None:
        """Return a robot's poses at beat 0 and now, if the leading stage simulates it."""
        latest = self._transports.get(True)
        if not latest or "poses" not in latest:
            return None
        return Pose(**latest["start"][robot]), Pose(**latest["poses"][robot])

    def as_json(self, score: Score | None) -> dict[str, Any]:
        """Return the start and end poses of the program's robots, how near they came to each other, and their measured
        errors, if any; also the robots that aren't in their places, which keep it from beginning."""
        found = outcome(self._transports.get(True), self._poses, self.errors, score)
        return {**found, "misplaced": self.misplaced} if self.misplaced else found
