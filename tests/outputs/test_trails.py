"""Trails of simulated robots: their arcs pass through every pose that the robot had."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

from improv_core.outputs.simulator.robot import MAX_PLACES, TimedPose, Trail
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.player.player import Player
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.motion import Pose
from tests.player.plays import to_play

FREQUENCY = 50


def check(program: str, robots: str = "", seconds: float = 10.0, slack: float = 1e-9) -> list[TimedPose]:
    """Play a program, and return the places of ada's trail, which is off her poses by at most `slack` meters."""
    simulator = Simulator()
    player = Player(simulator, lambda message: None, lambda: 0.0)
    analysis = analyze(program, read_robots(robots))
    assert analysis.ok
    player.take(to_play(score_of(analysis), 1, "restart"), 0.0)
    poses = {}
    for step in range(int(seconds * FREQUENCY)):
        player.advance(step / FREQUENCY)
        poses[step / FREQUENCY] = simulator.poses()["ada"]
    places = places_of(simulator)
    for at, pose in poses.items():
        if at <= places[-1].at:
            assert math.dist((pose.x, pose.y), on(places, at)) <= slack, at
    return places


def places_of(simulator: Simulator) -> list[TimedPose]:
    trail = simulator.snapshot().trails["ada"]
    assert isinstance(trail, Trail)
    return trail.places


def on(places: list[TimedPose], at: float) -> tuple[float, float]:
    """The point of a trail at a time: on the arc between two places."""
    index = next(index for index, place in enumerate(places) if place.at >= at)
    if index == 0:
        return places[0].x, places[0].y
    one, other = places[index - 1], places[index]
    turn, share = other.heading - one.heading, (at - one.at) / (other.at - one.at)
    far, direction = math.dist((one.x, one.y), (other.x, other.y)), math.atan2(other.y - one.y, other.x - one.x)
    chord = far * math.sin(turn * share / 2) / math.sin(turn / 2) if turn else far * share
    bearing = direction - turn / 2 * (1 - share)
    return one.x + chord * math.cos(bearing), one.y + chord * math.sin(bearing)


def test_a_trail_is_exactly_the_path() -> None:
    check("ada $ forward (forward || left) slow 2 (forward || right) left backward\n")


def test_a_full_circle_in_one_word_is_a_circle() -> None:
    assert len(check("ada $ slow 8 (forward || scale 8 left)\n")) > 12


def test_a_straight_line_has_two_places_however_long_it_takes() -> None:
    assert len(check("ada $ slow 9 forward rest\n")) == 2


def test_the_trail_of_an_accelerating_robot_is_close() -> None:
    check(
        "ada $ forward (forward || left) left forward\n",
        "[robots.ada]\nprofile = 'p'\n[profiles.p]\nbase = 'turtlebot4'\ndynamics = 'motors'\n",
        slack=0.003,
    )


def test_the_trail_of_a_robot_sliding_along_a_wall_is_close() -> None:
    wall = "[world]\nwalls = [[-9, 1, 9, 1]]\n"
    check("ada $ halfleft slow 8 scale 4 forward\n", f"[robots.ada]\nprofile = 'turtlesim'\n{wall}", slack=0.02)


def test_a_seek_begins_another_trail() -> None:
    simulator = Simulator()
    player = Player(simulator, lambda message: None, lambda: 0.0)
    player.take(to_play(score_of(analyze("ada $ forward left forward\n")), 1, "restart"), 0.0)
    player.advance(0.0)
    player.advance(1.5)
    player.take({"type": "seek", "beat": 2.0}, 1.5)
    (place,) = places_of(simulator)
    assert (place.x, place.heading) == pytest.approx((2.0, math.pi / 2))


def test_a_trail_that_is_too_long_loses_its_older_half() -> None:
    trail = Trail(0.0, Pose())
    for number in range(MAX_PLACES):
        trail.add(number + 1.0, Pose(number + 1.0))
    renewed = trail.renewed()
    assert renewed is not trail
    assert renewed.places == trail.places[MAX_PLACES // 2 :]
    assert renewed.renewed() is renewed
    assert Fraction(len(renewed.places), MAX_PLACES) < 1
