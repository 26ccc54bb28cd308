"""Speeds of robots, and changes that fit their limits."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.robots.limits import Excess, excess, unsupported
from improv_core.score.movement import Velocity
from improv_core.score.profiles import BUILT_IN, DEFAULT, HOLONOMIC, QUADROTOR, TURTLEBOT3_BURGER, TURTLESIM, Profile

FORWARD = Velocity(x=Fraction(1))
LEFT = Velocity(yaw=Fraction(1))
SIXTY = Fraction(60)
limited = replace(HOLONOMIC, max_linear=0.5, max_angular=1.0)

numbers = st.fractions(-20, 20, max_denominator=12)
velocities = st.builds(Velocity, numbers, numbers, numbers, numbers)
tempos = st.fractions(Fraction(1, 2), 400, max_denominator=4)


def test_a_speed_right_at_the_limit_is_within_it() -> None:
    # 0.2 m at 66 beats a minute is 0.22 m/s, though not in binary fractions.
    assert excess(FORWARD, TURTLEBOT3_BURGER, Fraction(66)) is None
    assert excess(FORWARD, TURTLEBOT3_BURGER, Fraction(67)) is not None


def test_limits_hold_for_commands_to_a_calibrated_robot() -> None:
    calibrated = replace(TURTLEBOT3_BURGER, linear_scale=1.1)
    assert excess(FORWARD, calibrated, SIXTY) is None  # 0.22 m/s
    assert excess(FORWARD, calibrated, Fraction(61)) is not None


def test_an_excess_has_its_ratio_and_values_that_fit() -> None:
    found = excess(FORWARD, TURTLEBOT3_BURGER, Fraction(90))
    assert found
    assert found == Excess(66, 2, "m/s", 0.3, 0.22, found.factor)
    assert found.factor == pytest.approx(0.3 / 0.22)


def test_the_most_exceeded_limit_is_named() -> None:
    both = Velocity(x=Fraction(2), yaw=Fraction(4))  # 0.4 m/s of 0.22; 6.28 rad/s of 2.84
    found = excess(both, TURTLEBOT3_BURGER, SIXTY)
    assert found
    assert (found.unit, found.tempo, found.slow) == ("rad/s", 27, 3)


def test_no_whole_tempo_may_fit() -> None:
    found = excess(Velocity(x=Fraction(1000)), limited, Fraction(1))
    assert found
    assert (found.tempo, found.slow) == (None, 7)


def test_without_limits_nothing_is_too_fast() -> None:
    assert excess(Velocity(x=Fraction(10**400)), TURTLESIM, SIXTY) is None


def test_numbers_beyond_all_floats_do_no_harm() -> None:
    found = excess(Velocity(x=Fraction(10**400)), limited, SIXTY)
    assert found
    assert (found.speed, found.factor, found.tempo) == (math.inf, math.inf, None)


@given(velocities, tempos)
def test_suggested_tempos_fit_and_are_the_fastest(velocity: Velocity, tempo: Fraction) -> None:
    found = excess(velocity, limited, tempo)
    if not found:
        return
    assert excess(velocity, limited, tempo / found.slow) is None
    assert found.slow - 1 < Fraction(found.factor).limit_denominator(10**6) <= found.slow
    if found.tempo:
        assert excess(velocity, limited, Fraction(found.tempo)) is None
    assert excess(velocity, limited, Fraction((found.tempo or 0) + 1)) is not None


@pytest.mark.parametrize("profile", BUILT_IN.values(), ids=lambda profile: profile.name)
def test_every_built_in_robot_can_step_at_the_default_tempo_and_turn_as_the_page_says(profile: Profile) -> None:
    assert excess(FORWARD, profile, SIXTY) is None
    turns_up_to = 38 if profile.name in ("husky", "leo_rover") else 60
    assert excess(LEFT, profile, Fraction(turns_up_to)) is None
    assert unsupported(Velocity(x=Fraction(-1), yaw=Fraction(1)), profile) == ()


@pytest.mark.parametrize("name", sorted(BUILT_IN.keys() - {"turtlesim", "puppet"}))
def test_every_built_in_robot_that_is_real_has_limits(name: str) -> None:
    for velocity in (FORWARD, LEFT):
        too_fast = excess(velocity, BUILT_IN[name], Fraction(6000))
        assert too_fast
        assert too_fast.tempo
        assert 38 <= too_fast.tempo <= 600


def test_unsupported_motions_are_listed() -> None:
    all_at_once = Velocity(Fraction(1), Fraction(1), Fraction(-1), Fraction(1))
    assert unsupported(all_at_once, TURTLEBOT3_BURGER) == ("strafe", "climb")
    assert unsupported(all_at_once, HOLONOMIC) == ("climb",)
    assert unsupported(all_at_once, QUADROTOR) == ()
    assert unsupported(all_at_once, DEFAULT) == ()
