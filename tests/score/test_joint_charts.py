"""Charts of joints: the position of each from beat to beat, and the stretches in which a limit holds it."""

from __future__ import annotations

import math
from xml.etree import ElementTree

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.joint_charts import curves
from improv_core.score.svg import plot

PUPPET = "ada is puppet\nbeat 120\n"
MAST = """
[profiles.lifter]
step = 1
[profiles.lifter.body.lift]
up = { joint = "mast", meters = 0.1 }
[profiles.lifter.joints.mast]
max = 0.25
[robots.bo]
profile = "lifter"
"""


def drawn(program: str, robots: str = "", beats: float = 8.0) -> dict[str, str]:
    """`0 0, 1 30` for each joint: beats and degrees, or centimeters, and after `|` the beats at which a limit holds
    it."""
    found = {}
    for curve in curves(score_of(analyze(program, read_robots(robots))), beats, 1000):
        unit = 100.0 if curve.joint.slides else 180 / math.pi
        points = dict.fromkeys(f"{beat:g} {round(position * unit):g}" for beat, position in curve.points)
        held = [f"{since:g} to {until:g} at {round(position * unit):g}" for since, until, position in curve.held]
        found[f"{curve.robot} {curve.joint.name}"] = " | ".join([", ".join(points), *held])
    return found


def test_a_limit_holds_a_joint_until_it_goes_back() -> None:
    assert drawn(PUPPET + "ada $ head (fast 2 left left left left right)\n") == {
        "ada head_yaw": "0 0, 0.5 30, 1.5 60, 2.5 90, 3.5 90, 4.5 60 | 2.5 to 3.5 at 90"
    }


def test_a_pose_is_reached_from_where_the_joint_is() -> None:
    assert drawn(PUPPET + "ada $ left_arm (up to high to start)\n") == {
        "ada left_shoulder_pitch": "0 0, 1 45, 2 150, 3 0"
    }


def test_only_joints_that_move_have_a_chart() -> None:
    assert drawn(PUPPET + "ada $ forward || head left\nbo $ forward\n") == {"ada head_yaw": "0 0, 1 30"}


def test_a_joint_that_slides_is_held_too() -> None:
    assert drawn("bo $ lift repeat 3 up\n", MAST) == {"bo mast": "0 0, 2.5 25, 3 25 | 2.5 to 3 at 25"}


def test_an_endless_movement_is_drawn_up_to_a_beat() -> None:
    nods = PUPPET + "ada $ head repeat (up down)\n"
    assert drawn(nods, beats=3.5) == {"ada head_pitch": "0 0, 1 20, 2 0, 3 20, 3.5 10"}
    assert drawn(PUPPET + "ada $ head (left repeat rest)\n", beats=2.0) == {"ada head_yaw": "0 0, 1 30, 2 30"}


def test_a_plot_has_a_chart_of_each_joint_that_moves() -> None:
    drawn = ElementTree.fromstring(plot(score_of(analyze(PUPPET + "ada $ head (left left left left)\nbo $ forward\n"))))
    texts = [each.text for each in drawn.iter("{http://www.w3.org/2000/svg}text")]
    assert texts == ["ada", "bo", "0.5 m", "ada head_yaw", "90°", "-90°"]
