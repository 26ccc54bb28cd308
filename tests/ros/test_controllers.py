"""Body parts of real robots, from a program to controllers that behave as ros2_control's (tests/ros/controller.py).

tests/outputs (test_trajectories.py, test_ros_controllers.py) tests the commands; here real controllers obey them.
The robot has a controller of each kind, and its base has nothing to do, so it needs no listener. The head's controller
also has a jaw, and the hand's a thumb, of which improv.toml knows nothing.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Mapping
from math import radians
from pathlib import Path
from typing import Any

import pytest

from tests.needs import lacking
from tests.processes import players
from tests.ros.conftest import LIMIT, Listen, Listener, Script
from tests.ros.dance import Terminal

pytestmark = pytest.mark.slow("processes of ROS find each other")

CONTROLLER = Path(__file__).parent / "controller.py"
TOML = """
[robots.ada]
profile = "nao"
[profiles.nao]
step = 1
joint_states = "joint_states"
{home}
[profiles.nao.body.head]
left = {{ joint = "yaw", degrees = 30 }}
up = {{ joint = "pitch", degrees = 20 }}
[profiles.nao.body.arm]
up = {{ joint = "elbow", degrees = 30 }}
[profiles.nao.body.hand]
up = {{ joint = "wrist", degrees = 30 }}
[profiles.nao.joints]
yaw = {{ max_velocity = 50 }}
pitch = {{ max = 30, max_velocity = 50 }}
elbow = {{ max_velocity = 50 }}
wrist = {{ max_velocity = 50 }}
[profiles.nao.controllers.head]
joints = ["yaw", "pitch"]
[profiles.nao.controllers.arm]
joints = ["elbow"]
interface = "position"
[profiles.nao.controllers.hand]
joints = ["wrist"]
interface = "{hand}"
"""
STATES = "/ada/joint_states"
RESTING = 25
"""Equal messages after which joints rest: half a second of them."""


def arguments_of(hand: str) -> list[str]:
    """Return the arguments of the script of the controllers; `hand` is the interface of the hand's."""
    made = ["head trajectory jaw yaw pitch", "arm position elbow", f"hand {hand} thumb wrist"]
    return [word for each in made for word in ("--controller", *each.split())]


def rest(joints: Listener) -> dict[str, float]:
    """Wait until all joints rest, and return their positions."""
    same: list[Any] = []

    def rests(message: Mapping[str, Any]) -> bool:
        if same and same[-1] != message["positions"]:
            same.clear()
        same.append(message["positions"])
        return len(same) >= RESTING

    return dict(joints.wait(rests)["positions"])


def test_joints_move_to_their_starts_and_then_as_the_program_says_and_stop_at_their_limits(
    listen: Listen, script: Script, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    """They move to their starts at a fifth of their highest speeds."""
    (tmp_path / "improv.toml").write_text(TOML.format(hand="position", home='home = "move"'))
    joints = listen(STATES, type="sensor_msgs/JointState")
    script(CONTROLLER, "ada", *arguments_of("position"), "--start", "yaw", "-0.3", "--start", "jaw", "0.4")
    program = "ada $ head (left left right || up up up) || arm (up up down) || hand (up up down)\n"
    with Terminal("play", tmp_path / "dance.improv", ros_env, program) as dance:
        assert dance.wait_for_line("joints move to their starts first").endswith(": yaw of ada by +17°\n")
        first = joints.wait(lambda message: message["positions"]["elbow"] > 0)
        assert first["positions"]["yaw"] > radians(-2), "near its start, or it has left it"
        assert dance.process.wait(LIMIT) == 0
    moved = dict.fromkeys(("yaw", "pitch", "elbow", "wrist"), radians(30))
    assert rest(joints) == pytest.approx({**moved, "jaw": 0.4, "thumb": 0.0})


def test_a_dance_whose_controller_refuses_everything_ends_with_exit_code_2(
    script: Script, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    (tmp_path / "improv.toml").write_text(TOML.format(hand="position", home=""))
    script(CONTROLLER, "ada", *arguments_of("position"), "--inactive", "head")
    with Terminal("play", tmp_path / "dance.improv", ros_env, "ada $ head (left right left)\n") as dance:
        line = dance.wait_for_line("joints of ada don't follow")
        assert line.endswith(
            "/ada/head_controller moves nothing: its log says if it is inactive or refuses what it gets\n"
        )
        code, _ = dance.end()
    assert code == 2


def test_joints_come_to_rest_if_the_stage_is_killed(
    listen: Listen, script: Script, alone: Mapping[str, str], tmp_path: Path
) -> None:
    """The standby stops the joints that never come to rest by themselves."""
    (tmp_path / "improv.toml").write_text(TOML.format(hand="velocity", home=""))
    joints = listen(STATES, type="sensor_msgs/JointState")
    script(CONTROLLER, "ada", *arguments_of("velocity"), **alone)
    program = "ada $ repeat (head left || arm up || hand up)\n"
    with Terminal("play", tmp_path / "dance.improv", alone, program) as dance:
        joints.wait(lambda message: all(message["positions"][joint] > 0.2 for joint in ("yaw", "elbow", "wrist")))
        os.kill(next(iter(players(dance.pid))), signal.SIGKILL)
        rest(joints)


@pytest.fixture
def action(ros_python: str) -> str:
    """The option that has a controller serve the action; its type isn't in the wheels."""
    if subprocess.run([ros_python, "-c", "import control_msgs.action"], capture_output=True).returncode:
        lacking("control_msgs is not installed: sh tests/ros/fetch.sh")
    return "--action"


def test_a_stop_cancels_the_goals_of_a_controller_without_a_topic(
    action: str, listen: Listen, script: Script, alone: Mapping[str, str], tmp_path: Path
) -> None:
    """Each trajectory was a goal that replaced the one before."""
    (tmp_path / "improv.toml").write_text(TOML.format(home="", hand="position"))
    joints = listen(STATES, type="sensor_msgs/JointState")
    options = [*arguments_of("position"), action, "head", "--deaf", "head"]
    controllers = script(CONTROLLER, "ada", *options, **alone)
    with Terminal("play", tmp_path / "dance.improv", alone, "ada $ repeat (head left)\n") as dance:
        joints.wait(lambda message: message["positions"]["yaw"] > 0.2)
        dance.process.send_signal(signal.SIGINT)
        dance.process.wait(LIMIT)
        rest(joints)
    refused, ends = json.loads(controllers.communicate(timeout=LIMIT)[0])
    assert not refused
    assert "aborted" in ends, "those that were replaced"
    assert "canceled" in ends or "succeeded" in ends, "by its end, if the stop comes late on a slow machine"


def test_a_controller_says_why_it_has_aborted_a_goal(
    action: str, script: Script, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    (tmp_path / "improv.toml").write_text(TOML.format(hand="position", home=""))
    script(CONTROLLER, "ada", *arguments_of("position"), action, "head", "--deaf", "head", "--jam", "yaw", "0.02")
    with Terminal("play", tmp_path / "dance.improv", ros_env, "ada $ head (left right left)\n") as dance:
        line = dance.wait_for_line("joints of ada don't follow")
        assert line.endswith("/ada/head_controller has aborted what it got: yaw violated its path tolerance\n")
        code, _ = dance.end()
    assert code == 2
