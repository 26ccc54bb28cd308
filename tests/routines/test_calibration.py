"""Calibration, from a base's wheels and its measurements to the settings with which it keeps to its path."""

from __future__ import annotations

import math
from dataclasses import astuple, replace
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from improv_core.program.analysis import analyze
from improv_core.protocol.fields import to_pose_json
from improv_core.protocol.robot_messages import MeasuredRobot
from improv_core.robots.config import read_robots
from improv_core.routines.calibration import (
    MAX_ROUNDS,
    PRECISION,
    QUARTERS,
    Goal,
    MeasuredSettings,
    Round,
    Straight,
    are_whole,
    calibrate,
    doubtful_distance,
    doubtful_turn,
    errors,
    goal_in,
    settings_of,
    straight_by_poses,
    straight_by_tape,
    straight_dance,
    turn_by_poses,
    turning_dance,
    with_settings,
)
from improv_core.score.dynamics import Wheels
from improv_core.score.motion import Pose, Twist
from improv_core.score.profiles import BUILT_IN, HUSKY, TURTLEBOT4, TURTLESIM

GOAL = Goal(10, 0.2, math.pi / 2)
SEPARATION = TURTLEBOT4.wheel_separation
NOMINAL = MeasuredSettings(0.2, math.pi / 2, 1.0)
START = Pose(3.0, -2.0, heading=2.5)
wheels = st.floats(0.9, 1.1)


def driven(told: MeasuredSettings, left: float, right: float) -> tuple[Pose, Pose]:
    """The poses after each dance of a base from `START`, whose wheels roll this far for each meter."""
    base = Wheels(left, right, SEPARATION, 0.0, "")
    dances = (Twist(x=told.commanded_step), GOAL.steps), (Twist(yaw=told.commanded_quarter_turn), QUARTERS)
    straight, turning = (
        START.after(base.rolling(twist.balanced(told.left_right, SEPARATION), 0), beats) for twist, beats in dances
    )
    return straight, turning


def measured(told: MeasuredSettings, left: float, right: float) -> Round:
    straight, turning = driven(told, left, right)
    return Round(straight_by_poses(START, straight), turn_by_poses(START, turning, GOAL))


@given(wheels, wheels, st.floats(0.9, 1.1), st.floats(0.95, 1.05), st.floats(0.95, 1.05))
@settings(max_examples=50)
def test_a_base_without_noise_is_calibrated_after_two_passes(
    left: float, right: float, step: float, turn: float, left_right: float
) -> None:
    told = MeasuredSettings(0.2 * step, math.pi / 2 * turn, left_right)
    for _ in range(2):  # the mean of the wheels also depends slightly on left_right
        told = calibrate(told, GOAL, [measured(told, left, right)], SEPARATION).settings
    after = measured(told, left, right)
    assert told.left_right == pytest.approx(left / right, abs=1e-4)
    assert after.straight.distance == pytest.approx(2.0, abs=2e-3)
    assert after.straight.bend == pytest.approx(0, abs=1e-3)
    assert after.turn == pytest.approx(4 * math.pi, abs=1e-3)


def test_noise_averages_out_and_its_size_is_known() -> None:
    lots = Random(1)
    exact = measured(NOMINAL, 0.96, 0.94)
    rounds = [
        Round(
            Straight(exact.straight.distance + lots.gauss(0, 0.02), exact.straight.bend + lots.gauss(0, 0.02)),
            exact.turn + lots.gauss(0, 0.1),
        )
        for _ in range(MAX_ROUNDS)
    ]
    found = calibrate(NOMINAL, GOAL, rounds, SEPARATION)
    right = calibrate(NOMINAL, GOAL, [exact], SEPARATION).settings
    for name in ("commanded_step", "commanded_quarter_turn", "left_right"):
        error = getattr(found.error, name)
        assert abs(getattr(found.settings, name) - getattr(right, name)) < 3 * error
        assert 0 < error < PRECISION * getattr(right, name)
    assert found.is_known
    assert not calibrate(NOMINAL, GOAL, rounds[:1], SEPARATION).is_known
    wild = [*rounds, Round(Straight(2.5, 0.0), 4 * math.pi)]
    assert not calibrate(NOMINAL, GOAL, wild, SEPARATION).is_known


@pytest.mark.parametrize(
    ("ahead", "aside", "distance", "bend"),
    [
        (1.9, 0.0, 1.9, 0.0),
        (1.0, 1.0, math.pi / 2, math.pi / 2),  # a quarter of a circle of 1 m to the left
        (1.0, -1.0, math.pi / 2, -math.pi / 2),
    ],
)
def test_a_tape_measures_the_end_of_an_arc(ahead: float, aside: float, distance: float, bend: float) -> None:
    straight = straight_by_tape(ahead, aside)
    assert (straight.distance, straight.bend) == pytest.approx((distance, bend))


@pytest.mark.parametrize("turned", [600.0, 684.0, 720.0, 750.0, 890.0])
def test_two_turns_are_known_from_two_headings(turned: float) -> None:
    end = START.then(Pose(heading=math.remainder(math.radians(turned), math.tau)))
    assert math.degrees(turn_by_poses(START, end, GOAL)) == pytest.approx(turned)


@pytest.mark.parametrize(
    ("straight", "why"),
    [
        (Straight(1.9, -0.1), None),
        (Straight(190.0, 0.0), "190.00 m can't be right for 2.00 m"),
        (Straight(0.0, 0.0), "0.00 m can't be right for 2.00 m"),
        (Straight(2.0, 2.0), "114.6° off a straight line can't be right"),
    ],
)
def test_impossible_distances_are_reported(straight: Straight, why: str | None) -> None:
    assert doubtful_distance(straight, 2.0) == why


@pytest.mark.parametrize(("turn", "why"), [(12.0, None), (2 * math.pi, None), (0.1, "5.7° can't be right for 720.0°")])
def test_impossible_turns_are_reported(turn: float, why: str | None) -> None:
    assert doubtful_turn(turn, GOAL.turn) == why


@pytest.mark.parametrize(
    ("begin", "end", "aligned", "whole"),
    [(0.02, 4.98, 1, True), (0.5, 4.98, 1, False), (0.02, 3.0, 1, False), (0.02, 4.98, 2, False)],
    ids=["whole", "late", "stops", "jumps"],
)
def test_poses_count_if_they_came_all_the_time(begin: float, end: float, aligned: int, whole: bool) -> None:
    def measured(performed: float, aligned: int) -> MeasuredRobot:
        pose = to_pose_json(Pose())
        return {
            "source": "geometry_msgs/PoseStamped",
            "frame": "map",
            "origin": pose,
            "pose": pose,
            "ideal": pose,
            "aligned": aligned,
            "follows": False,
            "beat": performed,
            "performed": performed,
            "wall": 0,
        }

    assert are_whole(measured(begin, 1), measured(end, aligned), 5.0) == whole


def test_errors_are_put_in_words() -> None:
    rounds = [Round(Straight(1.9, 0.05), 12.0), Round(Straight(1.8, 0.05), 12.0)]
    assert errors(GOAL, rounds) == "1.850 m instead of 2.000 m, 2.9° to the left; 687.5° instead of 720.0°"


@pytest.mark.parametrize("name", BUILT_IN)
def test_every_built_in_profile_can_dance_both(name: str) -> None:
    robots = read_robots(f'[robots.anna]\nprofile = "{name}"\n')
    profile = BUILT_IN[name]
    for program in (
        straight_dance("anna", profile, goal_in(2.0, profile), 60),
        turning_dance("anna", profile, 60),
    ):
        assert analyze(program, robots).diagnostics == ()


def test_a_profile_keeps_its_settings() -> None:
    settings = MeasuredSettings(0.2105, 1.65, 1.02)
    calibrated = with_settings(TURTLEBOT4, settings)
    assert settings_of(TURTLEBOT4) == NOMINAL
    assert astuple(settings_of(calibrated)) == pytest.approx(astuple(settings))
    assert (calibrated.step, calibrated.quarter_turn) == (0.2, math.pi / 2)


def test_the_dances_are_programs_within_the_limits() -> None:
    assert goal_in(2.0, TURTLEBOT4) == GOAL
    assert goal_in(2.0, replace(TURTLEBOT4, linear_scale=1.1)) == replace(GOAL, steps=9)  # longer steps, so fewer
    assert straight_dance("anna", TURTLEBOT4, GOAL, 60) == "beat 60\nanna $ repeat 10 forward rest\n"
    assert turning_dance("anna", HUSKY, 60) == "beat 38\nanna $ repeat 8 left rest\n"
    assert turning_dance("anna", TURTLESIM, 90) == "beat 90\nanna $ repeat 8 left rest rest\n"
