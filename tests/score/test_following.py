"""Feedback that pulls a robot back to its ideal path: its bounds, its stability, and its convergence."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from improv_core.score.dynamics import Motion, Wheels, follow, motors_of
from improv_core.score.following import GAIN, SAFE_DELAY, SHARE, accelerated, before_stopping, correction, refusal
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import BUILT_IN, HUSKY, TURTLEBOT4, Profile

LIMITS = 0.306, 1.9
PERIOD = 0.05

anywhere = st.floats(-1e6, 1e6)
poses = st.builds(Pose, anywhere, anywhere, st.just(0.0), anywhere)
speeds = st.floats(-10, 10)
limits = st.floats(0.001, 100)


@given(poses, st.builds(Twist, speeds, speeds, speeds, speeds), poses, limits, limits)
def test_it_never_exceeds_a_tenth_of_the_limits(
    ideal: Pose, twist: Twist, measured: Pose, linear: float, angular: float
) -> None:
    added = correction(ideal, twist, measured, (linear, angular))
    assert abs(added.x) <= SHARE * linear
    assert abs(added.yaw) <= SHARE * angular
    assert (added.y, added.z) == (0, 0)


@given(poses, st.builds(Twist, speeds, yaw=speeds), poses, limits, limits, st.floats(0.001, 100))
def test_it_steers_no_car_on_a_tighter_curve_than_it_can_drive(
    ideal: Pose, twist: Twist, measured: Pose, linear: float, angular: float, radius: float
) -> None:
    added = correction(ideal, twist, measured, (linear, angular), radius)
    if twist != STILL:
        assert abs(twist.yaw + added.yaw) * radius == pytest.approx(
            min(abs(twist.yaw + added.yaw) * radius, abs(twist.x + added.x)), rel=1e-9, abs=1e-9
        )


@given(poses, poses)
def test_a_robot_that_is_to_stand_is_not_moved(ideal: Pose, measured: Pose) -> None:
    assert correction(ideal, STILL, measured, LIMITS) == STILL


@pytest.mark.parametrize(
    ("measured", "twist", "expected"),
    [
        (Pose(1, 2), Twist(x=0.2), STILL),
        (Pose(0.99, 2), Twist(x=0.2), Twist(x=0.02)),  # it is behind: faster
        (Pose(1.01, 2), Twist(x=-0.2), Twist(x=-0.02)),
        (Pose(1, 2, heading=math.tau + 0.01), Twist(yaw=1), Twist(yaw=-0.02)),  # it has turned too far: less
        (Pose(1, 1.9), Twist(x=0.306), Twist(yaw=0.1 / 0.306)),  # it is to the right: steer to the left
        (Pose(1, 1.9), Twist(x=-0.306), Twist(yaw=-0.1 / 0.306)),  # backward, to the right
    ],
)
def test_it_pulls_toward_the_path(measured: Pose, twist: Twist, expected: Twist) -> None:
    added = correction(Pose(1, 2), twist, measured, (0.306, 100))
    assert (added.x, added.yaw) == pytest.approx((expected.x, expected.yaw), abs=1e-4)


def off_after(seconds: float, start: Pose, wheels: Wheels, late: int, *, follows: bool = True) -> tuple[float, float]:
    """The error of a unicycle that drives slow curves, corrected by poses that are this many periods old."""
    ideal, real, seen = Pose(), start, deque[tuple[Pose, Pose]]()
    for count in range(round(seconds / PERIOD)):
        twist = Twist(x=0.2, yaw=0.5 if count % 200 < 100 else -0.3)
        seen.append((ideal, real))
        told = twist
        if follows and len(seen) > late:
            expected, measured = seen.popleft()
            told = twist.plus(correction(expected, twist, measured, LIMITS))
        ideal, real = ideal.after(twist, PERIOD), real.after(wheels.rolling(told, 0), PERIOD)
    turn = math.remainder(ideal.heading - real.heading, math.tau)
    return math.dist((ideal.x, ideal.y), (real.x, real.y)), abs(turn)


@settings(max_examples=10, deadline=None)
@given(
    x=st.floats(-0.3, 0.3),
    y=st.floats(-0.3, 0.3),
    heading=st.floats(-1, 1),
    left=st.floats(0.95, 1.05),
    right=st.floats(0.95, 1.05),
    late=st.integers(0, 4),
)
def test_a_unicycle_with_wheel_errors_converges(
    x: float, y: float, heading: float, left: float, right: float, late: int
) -> None:
    off, turn = off_after(90.0, Pose(x, y, heading=heading), Wheels(left, right, 0.233, 0.0, ""), late)
    assert off < 0.06
    assert turn < 0.1


def test_without_it_the_same_unicycle_does_not() -> None:
    assert off_after(90.0, Pose(), Wheels(0.96, 0.94, 0.233, 0.0, ""), 0, follows=False)[1] > 0.2


@pytest.mark.parametrize(("delay", "converges"), [(SAFE_DELAY, True), (2.2 * SAFE_DELAY, False)])
def test_the_allowed_delay_is_half_of_what_makes_it_oscillate_forever(delay: float, *, converges: bool) -> None:
    step = 0.001
    errors = deque([1.0] * (round(delay / step) + 1), round(delay / step) + 1)
    for _ in range(round(30 / step)):
        errors.append(errors[-1] - GAIN * errors[0] * step)
    assert (max(map(abs, errors)) < 1e-6) == converges


def test_a_robot_with_limits_that_drives_and_turns_may_follow() -> None:
    able = {name for name, profile in BUILT_IN.items() if not refusal(profile)}
    assert able == {*BUILT_IN} - {"turtlesim", "holonomic", "quadrotor", "puppet"}


@pytest.mark.parametrize(
    ("profile", "why"),
    [
        (replace(TURTLEBOT4, motions=("forward", "turn", "strafe")), "works only with `motions = "),
        (replace(TURTLEBOT4, motions=("turn",)), "works only with `motions = "),
        (
            replace(TURTLEBOT4, max_angular=None),
            "corrects by a tenth of the limits: set `max_linear` and `max_angular`",
        ),
        (replace(TURTLEBOT4, command_rate=5), "would correct up to 0.43 s too late, and from 0.39 s on the robot may"),
        (replace(HUSKY, max_angular_acceleration=0.5), "would correct up to 0.45 s too late"),
    ],
)
def test_profiles_that_can_not_follow_are_refused(profile: Profile, why: str) -> None:
    assert (refusal(profile) or "").startswith(why)


@pytest.mark.parametrize("twist", [Twist(x=0.3), Twist(x=-0.3), Twist(yaw=1.5)])
def test_motors_that_get_going_are_as_far_behind_as_they_need_to_stop(twist: Twist) -> None:
    motors = motors_of(replace(TURTLEBOT4, dynamics="motors"), "r")
    assert motors
    accelerations = motors.linear_acceleration, motors.angular_acceleration
    commands = [(0.0, twist), (1.0, STILL)]
    going = follow(Motion(0.0, Pose()), commands, 0.9, motors)
    assert accelerated(STILL, twist, 0.9, accelerations) == going.twist == twist
    assert accelerated(STILL, twist, 0.1, accelerations).x == pytest.approx(max(-0.09, min(0.09, twist.x)))
    expected = before_stopping(Pose().after(twist, 0.9), twist, accelerations)
    real, rests = going.pose_at(0.9), follow(Motion(0.0, Pose()), commands, 2.0, motors).pose_at(2.0)
    ideal = Pose().after(twist, 1.0)
    assert (real.x, real.heading) == pytest.approx((expected.x, expected.heading), abs=1e-4)
    assert (rests.x, rests.heading) == pytest.approx((ideal.x, ideal.heading), abs=1e-4)
    unknown = math.inf, math.inf
    assert before_stopping(ideal, accelerated(STILL, twist, 0.0, unknown), unknown) == ideal
