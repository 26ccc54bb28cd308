"""Smoothed movements, movements that stay as they are, and the unchanged ends of robots."""

from __future__ import annotations

import math
from fractions import Fraction
from itertools import islice

import pytest

from improv_core.program.analysis import analyze
from improv_core.score.equality import same
from improv_core.score.measured import largest
from improv_core.score.motion import Pose, Twist
from improv_core.score.movement import Movement, Velocity
from improv_core.score.path import pose_at
from improv_core.score.profiles import TURTLESIM
from improv_core.score.score import Part
from improv_core.score.smoothing import smoothed
from improv_core.score.walk import walk


def movement(program: str) -> Movement:
    """The movement of `r` in the first scene."""
    analysis = analyze(program if "$" in program else f"r $ {program}")
    assert analysis.ok, analysis.diagnostics
    return analysis.parts["r"][0]


def check(program: str, written: str) -> None:
    """Check that the first program is smoothed as if the other had been written."""
    eased = movement(written)
    found = list(islice(walk(smoothed(movement(program))), 1_000))
    expected = list(islice(walk(eased), 1_000))
    assert [each[:3] for each in found] == [each[:3] for each in expected]
    assert smoothed(movement(program)).duration == eased.duration


@pytest.mark.parametrize(
    ("program", "written"),
    [
        ("forward", "ease forward"),
        ("forward forward left", "ease (forward forward) ease left"),
        ("repeat 3 forward", "ease (repeat 3 forward)"),
        ("repeat 3 (forward left)", "repeat 3 (ease forward ease left)"),
        ("repeat (forward left)", "repeat (ease forward ease left)"),
        ("forward backward", "ease forward ease backward"),
        ("rest forward rest rest", "rest ease forward rest rest"),
        ("forward || left", "ease (forward || left)"),
        ("slow 2 (forward left)", "slow 2 (ease forward ease left)"),
        ("reverse (forward left)", "reverse (ease forward ease left)"),
        ("a = forward left\nr $ a a", "a = ease forward ease left\nr $ a a"),
        (
            "choose (forward) (left) shuffle (forward) (left)",
            "choose (ease forward) (ease left) shuffle (ease forward) (ease left)",
        ),
        ("until near (forward left) forward", "until near (forward left) ease forward"),
        *(
            (same, same)
            for same in (
                "repeat forward",
                "(forward left) || (left left forward)",
                "ease (forward left)",
                "ramp 1 2 (forward left)",
                "until near (repeat forward)",
                "pause near (forward left)",
                "if near (forward) else (left)",
                "rest",
            )
        ),
    ],
)
def test_stretches_are_smoothed(program: str, written: str) -> None:
    check(program, written)


def test_movements_that_would_become_too_fast_are_not_smoothed() -> None:
    """A name of several stretches that is too fast in one place stays as it is everywhere."""

    def fits(velocity: Velocity) -> bool:
        return bool(abs(largest(velocity.x)) < 2 and abs(largest(velocity.yaw)) < 2)

    whole = movement("a = forward left\nr $ a fast 2 a slow 2 fast 3 right backward fast 3 left")
    rates = [moment.velocity for moment in walk(smoothed(whole, fits))]
    assert {velocity.x for velocity in rates if largest(velocity.x) >= 0} == {0, 1, 2}, "no 4/3 and no 8/3"
    assert {velocity.yaw for velocity in rates} == {0, 1, 2, Fraction(-3, 2), 3}
    assert min(largest(velocity.x) for velocity in rates) == Fraction(-4, 3)
    assert same(smoothed(whole, lambda velocity: False), whole)


@pytest.mark.parametrize(
    "program",
    [
        "forward halfleft fast 3 forward right backward",
        "a = forward halfright\nr $ repeat 7 (a slow 3/2 a strafeleft) reverse (a a)",
        "repeat 5 shuffle (forward) (left) (forward halfleft) (forward || left)",
        "(forward forward || left left) scale 3/7 (forward) reflect XZ (forward left)",
    ],
)
def test_the_end_is_exact_from_any_beat(program: str) -> None:
    """The pose of a robot after each beat, from any pose before, depends on the smoothed movement."""
    plain = movement(program)
    eased = smoothed(plain)
    assert eased.duration == plain.duration
    one, other = (Part("r", (each,), TURTLESIM, Pose(), "/r") for each in (plain, eased))
    close(pose_at(one, Fraction(plain.duration)), pose_at(other, Fraction(eased.duration)))
    for start in (Fraction(1, 3), Fraction(5, 2), Fraction(17, 5)):
        gone = pose_at(other, start)
        assert gone
        for moment in walk(eased, start):
            x, y, z, yaw = (float(largest(value * moment.duration)) for value in moment.velocity)
            gone = gone.after(Twist(x * 2, y * 2, z * 2, yaw * math.pi / 2), 1)
        close(gone, pose_at(one, Fraction(plain.duration)))


def close(one: Pose | None, other: Pose | None) -> None:
    assert one
    assert other
    for name in ("x", "y", "z", "heading"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), abs=1e-9)


def test_a_long_chain_of_names_is_smoothed() -> None:
    lines = ["a0 = forward left"] + [f"a{n} = a{n - 1} fast {n % 3 + 2} a{n - 1}" for n in range(1, 60)]
    whole = movement("\n".join([*lines, "r $ a59"]))
    eased = smoothed(whole, lambda velocity: abs(largest(velocity.x)) < 1e9)
    assert eased.duration == whole.duration
    assert len(list(islice(walk(eased), 100))) == 100


def test_equal_programs_are_equal_when_smoothed() -> None:
    """So a save leaves a robot alone whose part is the same."""
    one, other = (smoothed(movement("a = forward left\nr $ a forward forward")) for _ in range(2))
    assert one is not other
    assert same(one, other)
