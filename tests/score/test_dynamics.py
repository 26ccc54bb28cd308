"""Simulated robots follow their commands: exactly, or within the limits of their motors."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from statistics import stdev

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from improv_core.score.dynamics import Motion, Motors, Wheels, follow, motors_of
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import TURTLEBOT3_BURGER, TURTLEBOT4, TURTLESIM, Profile, beside_robots

BASE = Motors(max_linear=0.5, max_angular=2.0, linear_acceleration=0.8, angular_acceleration=4.0)
WORN = BASE._replace(wheels=Wheels(0.96, 0.94, separation=0.2, noise=0.0, seed="r"))
NOISY = BASE._replace(wheels=Wheels(1.0, 1.0, separation=0.2, noise=0.01, seed="r"))


def check(commands: list[tuple[float, Twist]], to: float, expected: Pose, motors: Motors | None = BASE) -> None:
    pose = follow(Motion(0.0, Pose()), commands, to, motors).pose_at(to)
    assert (pose.x, pose.y, pose.z) == pytest.approx((expected.x, expected.y, expected.z), abs=1e-9)
    assert pose.heading == pytest.approx(expected.heading, abs=1e-9)


def test_ideal_robots_have_no_motors() -> None:
    assert motors_of(TURTLEBOT4, "r") is None


def test_motors_have_the_limits_of_their_profile_or_else_ours() -> None:
    create = Profile("create", 0.2, max_linear_acceleration=0.9, max_angular=1.9, dynamics="motors")
    assert motors_of(create, "r") == Motors(None, 1.9, 0.9, 5.0)


def test_beside_real_robots_only_known_limits_count() -> None:
    burger = motors_of(beside_robots(TURTLEBOT3_BURGER), "r")
    assert burger == Motors(0.22, 2.84, math.inf, math.inf)
    assert motors_of(beside_robots(TURTLEBOT4), "r") == Motors(0.306, 1.9, 0.9, 7.725)
    assert motors_of(beside_robots(TURTLESIM), "r") is None
    assert beside_robots(replace(TURTLEBOT4, dynamics="motors")).dynamics == "motors"
    # As the sink scales velocities over a limit: half as fast, so half as far, and without acceleration.
    commands = [(0.0, Twist(x=0.44, yaw=1.0)), (2.0, STILL)]
    check(commands, 3.0, Pose().after(Twist(x=0.22, yaw=0.5), 2.0), burger)


def test_an_ideal_robot_is_at_its_speed_at_once() -> None:
    check([(0.0, Twist(x=0.4)), (2.0, STILL)], 3.0, Pose(0.8), motors=None)


def test_motors_gain_speed_and_lose_it() -> None:
    # 0.4 m/s at 0.8 m/s² takes 0.5 s and 0.1 m; and the same again after the stop.
    commands = [(0.0, Twist(x=0.4)), (2.0, STILL)]
    check(commands, 0.25, Pose(0.8 * 0.25**2 / 2))
    check(commands, 0.5, Pose(0.1))
    check(commands, 2.5, Pose(0.8))
    check(commands, 9.0, Pose(0.8))


def test_a_profile_with_errors_sets_the_wheels() -> None:
    worn = replace(TURTLEBOT4, dynamics="motors", wheel_error=(0.96, 0.94), noise=0.01, radius=0.1)
    motors = motors_of(worn, "anna")
    assert motors
    assert motors.wheels == Wheels(0.96, 0.94, pytest.approx(0.142), 0.01, "anna")  # type: ignore[arg-type]


def test_worn_wheels_turn_too_little_and_beside_the_middle() -> None:
    expected = Pose().after(Twist(x=-0.1 * 0.02 / 2, yaw=0.95), 3.0)
    check([(0.0, Twist(yaw=1.0)), (3.0, STILL)], 4.0, expected, WORN._replace(angular_acceleration=1e9))


def test_noise_is_the_same_each_time_and_as_large_as_the_profile_says() -> None:
    def ends(seed: str) -> list[Pose]:
        motors = NOISY._replace(wheels=NOISY.wheels._replace(seed=seed))  # type: ignore[union-attr]
        moving = Motion(0.0, Pose(), Twist(x=0.4), Twist(x=0.4))
        times = [second / 10 + 0.05 for second in range(1, 2001)]
        return [follow(moving, [], time, motors).pose_at(time) for time in (times[0], times[-1])]

    assert ends("r") == ends("r") != ends("s")
    turns = [NOISY.wheels.rolling(Twist(x=1.0), period).yaw for period in range(2000)]  # type: ignore[union-attr]
    # The difference of two wheels of 1% each, 0.2 m apart.
    assert stdev(turns) == pytest.approx(0.01 * math.sqrt(2) / 0.2, rel=0.1)


@pytest.mark.parametrize("motors", [BASE, WORN, NOISY], ids=["base", "worn", "noisy"])
@settings(max_examples=20)
@given(
    st.lists(
        st.tuples(st.floats(0, 3), st.builds(Twist, x=st.floats(-1, 1), y=st.floats(-1, 1), yaw=st.floats(-3, 3))),
        max_size=6,
    ).map(lambda commands: sorted(commands, key=lambda command: command[0])),
    st.lists(st.integers(0, 4 * 240), max_size=8).map(sorted),
)
def test_asking_in_between_changes_nothing_and_exceeds_no_limit(
    motors: Motors, commands: list[tuple[float, Twist]], steps: list[int]
) -> None:
    motion, left, passed = Motion(0.0, Pose()), commands, [Motion(0.0, Pose())]
    for step in [*steps, 4 * 240]:
        time = step / 240
        motion = follow(motion, left, time, motors)
        left = [command for command in left if command[0] > time]
        passed.append(Motion(time, motion.pose_at(time), motion.twist))
    at_once = follow(Motion(0.0, Pose()), commands, 4.0, motors)
    assert (motion.twist, motion.pose_at(4.0)) == (at_once.twist, at_once.pose_at(4.0))
    for before, after in pairwise(passed):
        seconds = after.at - before.at
        gained = math.dist((before.twist.x, before.twist.y), (after.twist.x, after.twist.y))
        assert gained <= BASE.linear_acceleration * seconds + 1e-9
        assert abs(after.twist.yaw - before.twist.yaw) <= BASE.angular_acceleration * seconds + 1e-9
        assert math.hypot(after.twist.x, after.twist.y) <= 0.5 + 1e-9


def test_left_right_makes_a_base_that_pulls_to_one_side_drive_straight() -> None:
    worn = replace(TURTLEBOT4, dynamics="motors", wheel_error=(0.96, 0.94), left_right=0.96 / 0.94)
    motors = motors_of(worn, "r")
    assert motors
    told = [(0.0, Twist(x=0.2)), (5.0, STILL)]
    at_once = motors._replace(linear_acceleration=1e9, angular_acceleration=1e9)
    check(told, 6.0, Pose(2 * 0.96 * 0.94 / (0.96 + 0.94)), at_once)  # the harmonic mean of both wheels, of a meter


def test_a_calibrated_base_drives_and_turns_as_far_as_it_should() -> None:
    worn = replace(
        TURTLEBOT4, dynamics="motors", wheel_error=(0.95, 0.95), linear_scale=1 / 0.95, angular_scale=1 / 0.95
    )
    motors = motors_of(worn, "r")
    assert motors
    at_once = motors._replace(linear_acceleration=1e9, angular_acceleration=1e9)
    check([(0.0, Twist(x=0.2)), (5.0, Twist(yaw=1.0)), (7.0, STILL)], 8.0, Pose(1.0, heading=2.0), at_once)
    check([(0.0, Twist(x=0.4)), (5.0, STILL)], 6.0, Pose(0.306 * 0.95 * 5), at_once)  # the limit applies to the command


def test_calibration_changes_nothing_about_a_base_without_errors() -> None:
    for dynamics in ("ideal", "motors"):
        profile = replace(TURTLEBOT4, dynamics=dynamics)
        pulling = replace(profile, left_right=0.98, linear_scale=1.1, angular_scale=1.1)
        assert motors_of(pulling, "r") == motors_of(profile, "r")
        assert motors_of(beside_robots(pulling), "r") == motors_of(beside_robots(profile), "r")
    assert replace(TURTLEBOT4, left_right=0.98).command_for(Twist(x=0.2)).yaw < 0  # it compensates to the right
