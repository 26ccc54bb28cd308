"""The poses at which movements end, compared with walking every moment."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.motion import Pose
from improv_core.score.movement import Movement
from improv_core.score.path import pose_at
from improv_core.score.score import Part, twist
from improv_core.score.walk import walk
from tests.random_programs import closed, score_of_text
from tests.score.test_movement import dances, movements
from tests.score.test_movement import part_of as part_with


def part_of(program: str) -> Part:
    return score_of(analyze(program)).parts["r"]


def walked(part: Part, until: Fraction) -> Pose:
    """The pose at a beat, by exact arcs from moment to moment."""
    pose = part.start
    for moment in walk(part.movement):
        left = min(moment.duration, until - moment.start)
        if left <= 0:
            break
        pose = pose.after(twist(moment.velocity, part.profile, Fraction(60)), float(left))
        pose = replace(pose, z=max(pose.z, 0.0))
    return pose


def check(part: Part, beat: Fraction) -> None:
    found, expected = pose_at(part, beat), walked(part, beat)
    assert found is not None
    for axis in ("x", "y", "z", "heading"):
        assert getattr(found, axis) == pytest.approx(getattr(expected, axis), abs=1e-8)


@given(movements | dances, st.fractions(0, 12, max_denominator=24))
def test_the_pose_is_where_walking_leads(movement: Movement, beat: Fraction) -> None:
    check(part_with(movement), beat)


@given(closed, st.fractions(0, 12, max_denominator=24))
def test_it_stays_on_the_ground_where_walking_would_lead_below(text: str, beat: Fraction) -> None:
    check(score_of_text(f"a $ {text}").parts["a"], beat)


@pytest.mark.parametrize(
    ("program", "height"),
    [
        ("a $ down down up", 1),
        ("a $ up down down up", 1),
        ("a $ repeat 1000000000 (up scale 2 down)", 0),
        ("a $ repeat 3 (scale 2 up down down down)", 0),
        ("a $ retrograde (down down up)", 2),
        ("a $ (down || slow 2 up) repeat 2 up", 2),
    ],
)
def test_nobody_sinks_into_the_ground(program: str, height: float) -> None:
    part = score_of_text(program).parts["a"]
    pose = pose_at(part, 10**12)
    assert pose is not None
    assert pose.z == pytest.approx(height * part.profile.step)


def test_the_billionth_turn_costs_no_more_than_the_second() -> None:
    part = part_of("r $ repeat (repeat 1000000 (forward left) halfleft forward)")
    pose = pose_at(part, Fraction(10**15) + Fraction(1, 2))
    assert pose is not None
    assert math.isfinite(pose.x)


def test_turns_that_throw_nothing_are_counted_too() -> None:
    assert pose_at(part_of("r $ repeat 1000000000 (forward left seed 2 ())"), 10**9) is None


def test_a_square_leads_back() -> None:
    pose = pose_at(part_of("r $ repeat 4000 (forward left)"), 8000)
    assert pose is not None
    assert (pose.x, pose.y, math.remainder(pose.heading, math.tau)) == pytest.approx((0, 0, 0), abs=1e-8)


def test_beyond_the_end_is_the_end() -> None:
    assert pose_at(part_of("r $ forward"), 100) == Pose(2.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    "program",
    [
        "r $ repeat (forward left) || repeat (slow 3/2 (forward right halfleft))",
        "r $ repeat forward || fast 2 (repeat (left left right))",
        "r $ retrograde (repeat 600 (forward left) || repeat 500 (left forward right))",
    ],
)
def test_voices_that_repeat_are_walked_once(program: str) -> None:
    part = part_of(program)
    check(part, Fraction(5999, 5))
    assert pose_at(part, 10**9) is not None


def test_long_voices_that_do_not_repeat_are_not_walked() -> None:
    assert pose_at(part_of("r $ repeat (forward left) || (left repeat (up down))"), 10**9) is None
