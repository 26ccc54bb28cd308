"""Performances whose clock jumps from one setpoint to the next: as fast as they can be computed."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction

from improv_core.outputs.simulator.collisions import touches
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.player.player import Player
from improv_core.protocol.messages import FromStage, Load, Play, Sensed
from improv_core.protocol.output import Sink
from improv_core.score.dynamics import STEPS_PER_SECOND
from improv_core.score.meetings import LAST_BEAT
from improv_core.score.motion import Pose
from improv_core.score.movement import FINEST, Exact, exact, near
from improv_core.score.performance import SenseSpan
from improv_core.score.prediction import Prediction, predicted
from improv_core.score.score import Score
from improv_core.score.senses import RobotSense, is_computed
from improv_core.slices import checkpoint

LONGEST = 120.0
"""The most seconds of a dance in which senses are decided in advance."""
MAX_STEPS = 40_000
"""The most steps of all robots together."""
PERIOD = 0.1
"""Seconds of the dance between two moments at which deciding senses in advance may be interrupted."""


def perform(
    score: Score,
    sink: Sink,
    seconds: float | None = None,
    tell: Callable[[FromStage], None] = lambda message: None,
    senses: Sequence[Sensed] | None = None,
) -> None:
    """Have a player send a score, or its first seconds, to a sink; `tell` gets its messages (docs/protocol.md).

    With `senses`, robots sense these and nothing else. The player follows no clock from outside and counts no bar,
    because nobody waits for a beat.
    """
    player = Player(sink, tell, lambda: 0.0)
    now = 0.0
    load: Load = {"type": "load", "generation": 1, "score": {}, "when": "restart", "backend": ""}
    if senses is not None:
        load["senses"] = senses
    player.take(Play(load, replace(score, clock=None, count_in=False)), now)
    while (deadline := player.deadline(now)) < math.inf:
        checkpoint()
        now = max(now, deadline)
        if seconds is not None and now >= seconds and player.run.mode == "playing":
            now = seconds
            player.take({"type": "stop"}, now)
        else:
            player.advance(now)


def simulate(
    score: Score,
    seconds: float | None,
    tell: Callable[[FromStage], None],
    senses: Sequence[Sensed] | None = None,
) -> dict[str, Pose]:
    """Perform a score, or its first seconds, in the simulator, as `perform` does. Return where its robots end."""
    simulator = Simulator(period=None)
    perform(score, simulator, seconds, tell, senses)
    return simulator.poses()


def predict(score: Score) -> Prediction | None:
    """Predict what the simulator's senses decide, with robots on their ideal paths: nobody pushes them, and they have
    no motors. All other senses never hold. None if the score reads no sense that the simulator computes.

    After 1,000 beats, two minutes of the dance, or `MAX_STEPS`, the score is cut off.
    """
    senses = {name: part.senses.values() for name, part in score.parts.items() if score.open}
    if not any(is_computed(each) for sources in senses.values() for each in sources):
        return None
    seconds = min(LONGEST, score.seconds(LAST_BEAT), MAX_STEPS / STEPS_PER_SECOND / len(score.parts))
    ideal = {
        name: replace(part, profile=replace(part.profile, dynamics="ideal", smooth=False))
        for name, part in score.parts.items()
    }
    felt = _Felt()
    perform(replace(score, parts=ideal), Simulator(PERIOD, touches), seconds, felt.take)
    assuming = {name for name, sources in senses.items() if not all(map(is_computed, sources))}
    return predicted(score, felt.spans(), near(seconds * float(score.tempo) / 60), frozenset(assuming))


class Predictions:
    """Predicts as `predict` does, and keeps the latest prediction: several ask about one text."""

    def __init__(self) -> None:
        self._latest: tuple[object, Prediction | None] | None = None

    def __call__(self, score: Score) -> Prediction | None:
        plays = [(part.scenes, part.start, part.profile) for part in score.parts.values()]  # the same movements
        if self._latest and self._latest[0] == (score.tempo, score.world, plays):
            return self._latest[1]
        found = predict(score)
        self._latest = (score.tempo, score.world, plays), found
        return found


class _Felt:
    """The times at which robots sensed something, by a player's messages."""

    def __init__(self) -> None:
        self._over: list[SenseSpan] = []
        self._begun: dict[RobotSense, Exact] = {}

    def take(self, message: FromStage) -> None:
        if message["type"] == "sensed":
            what = RobotSense(message["robot"], message["sense"])
            beat = exact(Fraction(math.floor(message["beat"] * FINEST), FINEST))  # not after what it decides
            if message["value"]:
                self._begun.setdefault(what, beat)
            elif what in self._begun:
                self._over.append(SenseSpan(what.sense, what.robot, self._begun.pop(what), beat))

    def spans(self) -> list[SenseSpan]:
        """Return the times at which each sense held."""
        return self._over + [SenseSpan(what.sense, what.robot, since) for what, since in self._begun.items()]
