"""Joints after movements, computed without performing them, compared with performing every moment."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.score.budget import Budget, TooLongError
from improv_core.score.joints import DisturbedError, JointOutcomes, joint_moments, limbs_of
from improv_core.score.score import Part
from tests.random_programs import closed, movements, score_of_text

TEMPO = score_of_text("a $ rest").tempo


def part_of(text: str) -> Part:
    return score_of_text(f"a $ {text}").parts["a"]


def check(part: Part, beat: Fraction) -> None:
    for limb in limbs_of(part, TEMPO):
        outcomes, begin = JointOutcomes(limb.part, limb.body), dict(limb.positions)
        performed = limb.performs(part.movement)
        try:
            found = outcomes.positions(begin, performed, beat, Budget(10_000))
        except DisturbedError:
            continue
        performing, moved = limb.positions, begin
        for moment, velocities, at in joint_moments(part.movement, limb):
            if moment.start >= beat:
                break
            performing, limb.positions = limb.positions, dict(at)
            limb.move(velocities, min(moment.duration, beat - moment.start))
            moved, limb.positions = limb.positions, performing
        assert found == pytest.approx(moved, abs=1e-9), limb.part.name


BEATS = st.fractions(0, 12, max_denominator=24)


@given(closed | movements(st.just("near")), BEATS)
def test_joints_are_where_performing_brings_them(text: str, beat: Fraction) -> None:
    check(part_of(text), beat)


@pytest.mark.parametrize(
    ("text", "beat"),
    [
        pytest.param("head (left left left left right)", 4.5, id="beyond a limit and back"),
        pytest.param("repeat head (left left left right)", 1_001.5, id="into a limit again and again"),
        pytest.param("repeat (head (left to aside down) || forward)", 1_000.25, id="pose beside the base"),
        pytest.param("ease head (right to start to aside)", 2.75, id="pose at another rate"),
        pytest.param("reflect sagittal (head to aside) head left", 1.5, id="mirrored pose"),
        pytest.param("head (choose (left right) repeat 3 chance 1/2 left)", 3.5, id="dice"),
        pytest.param("head (left || down) || repeat 2 head (up left)", 1.5, id="voices of one part"),
    ],
)
def test_joints_are_where_they_were_performed_to(text: str, beat: float) -> None:
    check(part_of(text), Fraction(beat))


def test_the_billionth_turn_costs_no_more_than_the_second() -> None:
    part = part_of("repeat head (left left left right to aside)")
    (limb,) = limbs_of(part, TEMPO)
    outcomes, performed = JointOutcomes(limb.part, limb.body), limb.performs(part.movement)
    beats = Fraction(15, 2), Fraction(10**10 + 5, 2)
    second, billionth = (outcomes.positions(limb.positions, performed, beat, Budget(50)) for beat in beats)
    assert billionth == pytest.approx(second, abs=1e-9)
    with pytest.raises(TooLongError):
        JointOutcomes(limb.part, limb.body).positions(limb.positions, performed, 7, Budget(2))
