"""Twists within limits: never over them, and always of the same shape."""

from __future__ import annotations

import math
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.score.motion import STILL, Pose, Twist

speeds = st.floats(-1e6, 1e6)
twists = st.builds(Twist, speeds, speeds, speeds, speeds)
limits = st.none() | st.floats(0.001, 100)


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (Twist(0.22, 0, 0, 2.84), Twist(0.22, 0, 0, 2.84)),
        (Twist(0.44, 0, 0, 1.0), Twist(0.22, 0, 0, 0.5)),
        (Twist(-0.88, 0, 0, 5.68), Twist(-0.22, 0, 0, 1.42)),
        (Twist(0.264, 0, 0.352, 0), Twist(0.132, 0, 0.176, 0)),
        (STILL, STILL),
    ],
)
def test_a_twist_is_scaled_by_one_factor(asked: Twist, told: Twist) -> None:
    assert asked.within(0.22, 2.84) == told


def test_a_twist_over_a_limit_only_by_rounding_is_put_right() -> None:
    assert 0.2 * 1.1 > 0.22
    assert 0.22 - 1e-15 < Twist(0.2 * 1.1).within(0.22, None).x <= 0.22


@given(twists, limits, limits)
def test_no_limit_is_exceeded_and_no_shape_changed(asked: Twist, linear: float | None, angular: float | None) -> None:
    told = asked.within(linear, angular)
    assert linear is None or math.hypot(told.x, told.y, told.z) <= linear
    assert angular is None or abs(told.yaw) <= angular
    if math.hypot(asked.x, asked.y, asked.z) <= (linear or math.inf) and abs(asked.yaw) <= (angular or math.inf):
        assert told is asked
    elif min(map(abs, (asked.x, asked.yaw, told.x, told.yaw))) >= sys.float_info.min:  # below it, few digits are left
        assert told.x / asked.x == pytest.approx(told.yaw / asked.yaw)


@pytest.mark.parametrize("speed", [1e308, 5e-324])
def test_the_largest_and_smallest_floats_stay_within_limits(speed: float) -> None:
    told = Twist(speed, speed, speed, speed).within(0.22, 2.84)
    assert math.hypot(told.x, told.y, told.z) <= 0.22


def test_a_balanced_twist_drives_both_wheels_equally_far() -> None:
    told = Twist(x=0.2, yaw=0.5, y=0.1).balanced(0.96 / 0.94, 0.233)
    left, right = (told.x - told.yaw * 0.233 / 2) * 0.96, (told.x + told.yaw * 0.233 / 2) * 0.94
    assert (right - left) / ((left + right) / 2) == pytest.approx(0.5 * 0.233 / 0.2)
    assert told.y == 0.1
    assert STILL.balanced(0.98, 0.233) == STILL


@pytest.mark.parametrize(("x", "y", "ahead", "left"), [(1, 0, 2, 2), (0, 1, -2, 2), (1, 1, 0, 4)])
def test_a_quarter_turn_to_the_left_is_an_arc_in_any_direction(x: float, y: float, ahead: float, left: float) -> None:
    pose = Pose().after(Twist(x, y, yaw=math.pi / 2), 1)
    assert (pose.x, pose.y, pose.heading) == pytest.approx((ahead / math.pi, left / math.pi, math.pi / 2))
