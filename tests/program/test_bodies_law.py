"""Random programs with body parts and poses do the same as in an evaluator that was written from the law alone."""

from __future__ import annotations

import random

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import compiled
from improv_core.robots.config import read_robots
from tests.program.bodies_law import DRIVES, TOML, Stretch, beats_of, movement, performed

PROGRAMS = 60
STARTS = {drive.joint: drive.start for part in DRIVES.values() for drive in part.values()}
LONGEST = 60
"""The most pieces of a program: longer ones only take longer."""


def commanded(joints: dict[str, list[list[float]]], joint: str, at: float) -> float:
    """Return the compiled velocity of a joint at a time."""
    return next((speed for begin, seconds, speed in joints.get(joint, []) if begin <= at < begin + seconds), 0.0)


@pytest.mark.parametrize("seed", range(4))
def test_random_programs_obey_the_law(seed: int) -> None:
    dice, robots, done = random.Random(seed), read_robots(TOML), 0
    assert robots.diagnostics == ()
    while done < PROGRAMS:
        term = movement(dice, dice.choice([2, 3, 4]))
        pieces = term.pieces()
        if len(pieces) > LONGEST:
            continue
        program, done = f"beat 60\nr $ {term.text}\n", done + 1
        analysis = analyze(program, robots)
        assert analysis.ok, (program, analysis.diagnostics)
        found = compiled(analysis)["robots"]["r"]
        assert found["seconds"] == pytest.approx(float(beats_of(pieces))), program
        check(found, performed(pieces), program)


def check(found: dict[str, dict[str, list[list[float]]]], stretches: list[Stretch], program: str) -> None:
    for each in stretches:
        for joint, velocity in each.velocities.items():
            speed = commanded(found["joints"], joint, (each.begin + each.end) / 2)
            assert speed == pytest.approx(velocity, abs=1e-7), (program, joint, each.begin)
    for joint, (least, most) in found["range"].items():
        ends = [STARTS[joint], *(each.positions[joint] for each in stretches)]
        assert (least, most) == pytest.approx((min(ends), max(ends)), abs=1e-7), (program, joint)
