"""Robots that react in the real simulator, faster than real time."""

from __future__ import annotations

import cmath
import math
import random
from dataclasses import replace

import pytest
from hypothesis import settings

from improv_core.commands.rehearsal import perform
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.player.reports import Told
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.motion import Pose
from improv_core.score.score import Score
from improv_core.score.world import Box, Circle, Wall, World

ROAMER = "anna $ repeat (until near (repeat forward) [left left])\n"
ORIGIN = Pose()


def score(program: str, world: World, start: Pose = ORIGIN) -> Score:
    analysis = analyze(program)
    assert analysis.ok
    made = score_of(analysis)
    return replace(made, world=world, parts={name: replace(part, start=start) for name, part in made.parts.items()})


def walled(dice: random.Random) -> World:
    """A world with things in it that leave room for a robot in the middle."""

    def away() -> complex:
        return cmath.rect(dice.uniform(1.5, 6), dice.uniform(-math.pi, math.pi))

    def wall() -> Wall:
        middle, along = away(), away() / 8
        return Wall((middle - along).real, (middle - along).imag, (middle + along).real, (middle + along).imag)

    return World(
        (dice.uniform(4, 12), dice.uniform(4, 12)),
        tuple(wall() for _ in range(dice.randrange(4))),
        tuple(Circle(at.real, at.imag, dice.uniform(0.1, 0.8)) for at in (away() for _ in range(dice.randrange(4)))),
        tuple(
            Box(at.real, at.imag, dice.uniform(0.1, 0.8), dice.uniform(0.1, 0.8), dice.uniform(0, 3))
            for at in (away() for _ in range(dice.randrange(4)))
        ),
    )


@pytest.mark.parametrize("seed", range(settings().max_examples // 10))
def test_a_roamer_never_hits_a_wall(seed: int) -> None:
    dice = random.Random(seed)
    simulator, told = Simulator(period=None), list[Told]()
    start = Pose(heading=dice.uniform(-math.pi, math.pi))
    perform(score(ROAMER, walled(dice), start), simulator, 20.0, told.append)
    assert simulator.warnings() == {}
    decided = [each for each in told if each["type"] == "decided"]
    assert decided
    assert all((each["robot"], each["held"]) == ("anna", True) for each in decided)


def test_it_would_hit_a_wall_if_it_did_not_look() -> None:
    simulator = Simulator(period=None)
    perform(score("anna $ repeat forward\n", World((6, 6))), simulator, 20.0)
    assert simulator.warnings()
