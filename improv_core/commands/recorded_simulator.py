"""A simulator in which robots sense and react, and which records their commands."""

from __future__ import annotations

import math
from collections.abc import Mapping

from improv_core.outputs.recording.recorder import Recorder
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.score.joints import JointMotion
from improv_core.score.motion import Twist
from improv_core.score.score import Score


class RecordedSimulator(Simulator):
    """A simulator without a page that also passes all its commands to a recorder."""

    def __init__(self, recorder: Recorder) -> None:
        super().__init__(period=None)
        self._recorder = recorder

    def prepare(self, score: Score, restart: bool) -> None:
        super().prepare(score, restart)
        self._recorder.prepare(score, restart)

    def send(self, robot: str, twist: Twist, at: float) -> None:
        self._recorder.send(robot, twist, at)
        super().send(robot, twist, at)

    def send_joints(
        self, robot: str, joints: Mapping[str, JointMotion], at: float, pace: float = 1.0, until: float = math.inf
    ) -> None:
        self._recorder.send_joints(robot, joints, at)
        super().send_joints(robot, joints, at, pace, until)
