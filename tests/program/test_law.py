"""Random programs with body parts, poses, and measures do the same as in an evaluator that was written from the law
alone."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import compiled
from improv_core.robots.config import read_robots
from improv_core.syntax.formatter import format_text
from tests.program.law import DRIVES, PHRASES, TOML, Stretch, beats_of, movement, performed

PROGRAMS = 60
STARTS = {drive.joint: drive.start for part in DRIVES.values() for drive in part.values()}
LONGEST = 60
"""The most pieces of a program: longer ones only take longer."""


@pytest.mark.parametrize("seed", range(4))
def test_random_programs_obey_the_law(seed: int) -> None:
    dice, robots, done = random.Random(seed), read_robots(TOML), 0
    assert robots.diagnostics == ()
    while done < PROGRAMS:
        term = movement(dice, dice.choice([2, 3, 4]))
        pieces = term.pieces()
        if len(pieces) > LONGEST:
            continue
        program, done = f"beat 60\n{PHRASES}r $ {term.text}\n", done + 1
        analysis = analyze(program, robots)
        assert analysis.ok, (program, analysis.diagnostics)
        found = compiled(analysis)["robots"]["r"]
        assert found["beats"] == str(beats_of(pieces)), program
        check(found, performed(pieces), program)
        assert compiled(analyze(format_text(program), robots))["robots"]["r"] == found


def check(found: dict[str, Any], stretches: Sequence[Stretch], program: str) -> None:
    for each in stretches:
        middle = (each.begin + each.end) / 2
        base = commanded(found["segments"], middle) or [0.0] * 4
        assert base == pytest.approx(each.base, rel=1e-9, abs=1e-7), (program, each.begin)
        for joint, velocity in each.velocities.items():
            speed = commanded(found["joints"].get(joint, []), middle) or [0.0]
            assert speed == pytest.approx([velocity], rel=1e-9, abs=1e-7), (program, joint, each.begin)
    for joint, (least, most) in found["range"].items():
        ends = [STARTS[joint], *(each.positions[joint] for each in stretches)]
        assert (least, most) == pytest.approx((min(ends), max(ends)), rel=1e-9, abs=1e-7), (program, joint)


def commanded(segments: Sequence[Sequence[float]], at: float) -> Sequence[float]:
    """Return the compiled velocities at a time; none before and after all segments."""
    return next((speeds for begin, seconds, *speeds in segments if begin <= at < begin + seconds), [])
