"""The examples in which robots react, in the real simulator, faster than real time."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from typing import Any

import pytest

from improv_core.commands.programs import read_to_play
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.program.compiler import score_of
from improv_core.protocol.messages import FromStage
from improv_core.score.senses import CUE
from improv_core.stage.dry_run import perform
from tests.commands.command_line import REACTING

DANCERS = ["ada", "bo", "cy"]


def played(name: str, senses: Sequence[Any] | None = None) -> list[FromStage]:
    """Play an example for a minute at most, and return the reports; with `senses`, robots sense only these."""
    analysis = read_to_play(next(path for path in REACTING if path.stem == name))
    assert analysis
    told: list[FromStage] = []
    perform(score_of(analysis), Simulator(period=None), 60.0, told.append, senses)
    return told


def decided(told: Iterable[FromStage]) -> list[tuple[str, float]]:
    """The robots that reacted, and the beats."""
    return [(each["robot"], each["beat"]) for each in told if each["type"] == "decided"]


@pytest.mark.parametrize(
    ("name", "react", "bump"),
    [("roamer", {"anna"}, []), ("passing", {"anna", "bo"}, []), ("bump", {"ada", "bo"}, ["ada", "bo"])],
)
def test_robots_bump_into_something_only_if_the_example_says_so(
    name: str, react: Collection[str], bump: Sequence[str]
) -> None:
    told = played(name)
    assert {robot for robot, _ in decided(told)} == react
    sensed = [each for each in told if each["type"] == "sensed" and each["sense"] == "bump"]
    assert sorted(each["robot"] for each in sensed if each["value"]) == bump


def test_dancers_wait_for_the_cue_and_dance_after_it() -> None:
    assert decided(played("cue")) == []
    cues = [{"beat": beat, "robot": robot, "sense": CUE, "value": True} for beat in (6.5, 20.25) for robot in DANCERS]
    told = played("cue", cues)
    assert decided(told) == [(robot, beat) for beat in (6.5, 20.25) for robot in DANCERS]
    scenes = [each["scene"] for each in told if each["type"] == "transport" and "scene" in each]
    assert scenes[0] == {"index": 1, "begins": 7}, "the canon begins on the next whole beat"
