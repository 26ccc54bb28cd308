"""A score in which all that senses decide has been predicted, so its movements are closed. Standard library only."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from improv_core.score.algebra import from_statement, hold, series
from improv_core.score.movement import Exact, Movement
from improv_core.score.performance import Mover, SenseSpan, perform
from improv_core.score.score import Score
from improv_core.score.senses import RobotSense
from improv_core.score.walk import Moment


@dataclass(frozen=True, slots=True)
class Prediction:
    """A score in which no sense decides anything any more.

    It ends at beat `cut`, if more would follow; otherwise, that is None. Robots in `assuming` also read senses that
    nobody could compute: these never hold. `held` are the senses that hold at least once.
    """

    score: Score
    cut: Exact | None
    assuming: frozenset[str]
    held: frozenset[RobotSense]


Predict = Callable[[Score], Prediction | None]
"""A function that finds out what robots will sense. None if their surroundings decide nothing in a score."""


def predicted(score: Score, script: Sequence[SenseSpan], end: Exact, assuming: frozenset[str]) -> Prediction:
    """Return a score that plays from the beginning, with these senses and no others, up to a beat."""
    scenes = [
        {Mover(name): part.of_scene(scene) for name, part in score.parts.items()} for scene in range(score.scenes)
    ]
    found: dict[str, list[list[Moment]]] = {name: [[] for _ in scenes] for name in score.parts}
    cut: Exact | None = None
    for scene, mover, moment in perform(scenes, script):
        if moment.start + moment.duration > end:
            if moment.start >= end:
                cut = end
                break
            moment = moment._replace(duration=end - moment.start)
        moments = found[mover.robot][scene]
        if moments and moments[-1][2:] == moment[2:]:  # it was interrupted by a change of another robot
            begun = moments.pop()
            moment = begun._replace(duration=begun.duration + moment.duration)
        moments.append(moment)
    parts = {
        name: replace(part, scenes=tuple(series([*map(_played, scene)]) for scene in found[name]), scene_begins=())
        for name, part in score.parts.items()
    }
    held = frozenset(RobotSense(each.robot, each.sense) for each in script if each.robot)
    return Prediction(replace(score, parts=parts), cut, assuming, held)


def _played(moment: Moment) -> Movement:
    """Return a moment as a movement that the same words play."""
    if not moment.sources:
        return hold(moment.velocity, moment.duration)
    *around, word = moment.sources
    played, statement = hold(moment.velocity, moment.duration, word.span), word.statement
    for source in reversed(around):
        played, statement = from_statement(played, source.span, statement), source.statement
    return from_statement(played, None, statement)
