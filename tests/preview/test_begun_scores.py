"""The score that reports of a simulator describe, compared with the one that its player plays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import astuple

import pytest

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.player.player import Player
from improv_core.preview.begun_scores import BegunScores
from improv_core.protocol.messages import FromStage, When
from improv_core.score.score import Score
from improv_core.session.state import PartEditions
from tests.player.test_player import Stage, score


class Followed(Stage):
    """A player with the simulator, each of whose reports is compared with what it plays."""

    def __init__(self) -> None:
        super().__init__()
        self.player = Player(Simulator(), self._tell, lambda: 0.0)
        self.compared: list[int] = []
        """The scenes that played, at each report."""
        self._begun = BegunScores()
        self._editions = PartEditions()
        self._generation = 0

    def load(self, program: str, when: When = "restart") -> None:
        self._generation += 1
        self._editions, numbered = self._editions.number(score(program), self._generation)
        self._begun.add_score(numbered, self._generation)
        self.perform(numbered, self._generation, when)

    def _tell(self, message: FromStage) -> None:
        if message["type"] == "transport" and self._begun.knows(message["generation"]):
            assert _beginnings(self._begun.take(message)) == _beginnings(self.player.run.score)
            self.compared.append(self.player.run.score.scene)


def _beginnings(score: Score) -> object:
    """Return all that isn't known before a score plays; poses are rounded, as the simulator moves in steps."""
    parts = {
        robot: (part.begins, part.scene, [round(value, 6) for value in astuple(part.entered or part.start)])
        for robot, part in score.parts.items()
    }
    return score.scene, score.since, parts


SQUARE = "beat 120\na at 0 0\nb at 0 3\na $ repeat (forward left)\nb $ repeat forward\n"
TURNED = SQUARE.replace("repeat forward", "repeat left")
REACTS = "beat 120\na at 0 0\nb at 0 3\na $ until cue (repeat forward) left\nb $ repeat (forward left)\n"
SCENES = "beat 120\na $ until cue (repeat forward)\n---\na $ forward left\n---\na $ repeat backward\n"
Then = Callable[[Followed], None]


def cue(stage: Followed) -> None:
    stage.ask("cue")


def seek(stage: Followed) -> None:
    stage.ask("seek", beat=0.5)


def save(program: str, when: When) -> Then:
    return lambda stage: stage.load(program, when)


@pytest.mark.parametrize(
    ("program", "then", "scenes"),
    [
        (SQUARE, [save(TURNED, "now")], {0}),
        (SQUARE, [save(TURNED, "bar"), save(SQUARE, "beat"), save(TURNED, "restart")], {0}),
        (REACTS, [cue, save(REACTS.replace("(forward left)", "left"), "now")], {0}),
        (SCENES, [cue], {0, 1}),  # the beat of the last scene is known when the second one begins
        (SCENES, [cue, seek], {0, 1}),
        (SCENES, [cue, save(SCENES.replace("backward", "left"), "now")], {0, 1, 2}),
    ],
)
def test_the_score_that_reports_describe_is_the_one_that_plays(
    program: str, then: Sequence[Then], scenes: set[int]
) -> None:
    stage = Followed()
    stage.load(program)
    for each in then:
        stage.run(1.3)
        each(stage)
    stage.run(6.1)
    stage.ask("pause")
    assert {*stage.compared} == scenes
    assert len(stage.compared) > len(then)
