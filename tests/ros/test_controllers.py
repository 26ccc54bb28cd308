"""Body parts of real robots, from a program to controllers that behave as ros2_control's (tests/ros/controller.py).

tests/outputs (test_trajectories.py, test_ros_controllers.py) tests the commands; here real controllers obey them.
The robot has a controller of each kind, and its base has nothing to do, so it needs no listener.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from itertools import count
from math import radians
from pathlib import Path
from typing import Any

import pytest

from tests.processes import lines_until, players
from tests.ros.conftest import LIMIT, Listen, Listener, Script

pytestmark = pytest.mark.slow("processes of ROS find each other")

CONTROLLER = Path(__file__).parent / "controller.py"
TOML = """
[robots.{robot}]
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
RESTING = 25
"""Equal messages after which joints rest: half a second of them."""
_names = count()


class Dance:
    """A program that `improv play` plays for a robot, and a listener to its joints."""

    def __init__(self, folder: Path, env: Mapping[str, str], program: str, **profile: str) -> None:
        self.robot = f"ada{next(_names)}"
        (folder / "improv.toml").write_text(TOML.format(robot=self.robot, **profile))
        path = folder / "dance.improv"
        path.write_text(program.format(robot=self.robot))
        command = [sys.executable, "-m", "improv_core", "play", "--backend", "ros", str(path)]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, env={**env}, stdin=subprocess.DEVNULL, stderr=pipe, text=True)

    def wait_for_line(self, part: str) -> str:
        return lines_until(part, self.process.stderr)[-1]

    def close(self) -> None:
        self.process.terminate()
        self.process.communicate(timeout=LIMIT)


def arguments_of(hand: str) -> list[str]:
    """Return the arguments of the script of the controllers; `hand` is the interface of the hand's."""
    made = ["head trajectory yaw pitch", "arm position elbow", f"hand {hand} wrist"]
    return [word for each in made for word in ("--controller", *each.split())]


Begin = Callable[..., tuple[Dance, Listener]]


@pytest.fixture
def begin(
    script: Script, listen: Listen, ros_env: dict[str, str], tmp_path: Path, where: int | None
) -> Iterator[Begin]:
    """Play a program: `begin(PROGRAM, "--start", "yaw", "0.5")`. Each robot has its own name."""
    env = ros_env if where is None else {**ros_env, "ROS_DOMAIN_ID": str(where)}
    with ExitStack() as stack:

        def play(program: str, *options: str, hand: str, home: str = "") -> tuple[Dance, Listener]:
            dance = Dance(tmp_path, env, program, hand=hand, home=home)
            stack.callback(dance.close)
            joints = listen(f"/{dance.robot}/joint_states", type="sensor_msgs/JointState")
            script(CONTROLLER, dance.robot, *arguments_of(hand), *options, ROS_DOMAIN_ID=env["ROS_DOMAIN_ID"])
            return dance, joints

        yield play


def rest(joints: Listener) -> dict[str, float]:
    """Wait until all joints rest, and return their positions."""
    same: list[Any] = []

    def rests(message: Mapping[str, Any]) -> bool:
        if same and same[-1] != message["positions"]:
            same.clear()
        same.append(message["positions"])
        return len(same) >= RESTING

    return dict(joints.wait(rests)["positions"])


def test_joints_move_to_their_starts_and_then_as_the_program_says_and_stop_at_their_limits(begin: Begin) -> None:
    """They move to their starts at a fifth of their highest speeds."""
    dance, joints = begin(
        "{robot} $ head (left left right || up up up) || arm (up up down) || hand (up up down)\n",
        *("--start", "yaw", "-0.3"),
        hand="position",
        home='home = "move"',
    )
    line = dance.wait_for_line("joints move to their starts first")
    assert line.endswith(f": yaw of {dance.robot} by +17°\n")
    first = joints.wait(lambda message: message["positions"]["elbow"] > 0)
    assert first["positions"]["yaw"] > radians(-2), "near its start, or it has left it"
    assert dance.process.wait(LIMIT) == 0
    assert rest(joints) == pytest.approx(dict.fromkeys(("yaw", "pitch", "elbow", "wrist"), radians(30)))


def test_joints_come_to_rest_if_the_stage_is_killed(begin: Begin, alone: Mapping[str, str]) -> None:
    """The standby stops the joints that never come to rest by themselves."""
    dance, joints = begin("{robot} $ repeat (head left || arm up || hand up)\n", hand="velocity")
    joints.wait(lambda message: all(message["positions"][joint] > 0.2 for joint in ("yaw", "elbow", "wrist")))
    os.kill(next(iter(players(dance.process.pid))), signal.SIGKILL)
    rest(joints)
