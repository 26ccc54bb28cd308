"""Body parts of real robots, from a program to controllers that do what ros2_control's do (tests/ros/controller.py).

tests/stage/test_controllers.py asks what they are sent; here real ones obey it, and come to rest whatever fails. The
robot has a controller of each kind, and its base has nothing to do, so nobody need listen to it.
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

from tests.processes import players
from tests.ros.conftest import LIMIT, Listen, Listener, Others, Publish, Script
from tests.ros.hosts import Host, on_one_link, set_link

pytestmark = pytest.mark.slow("processes of ROS find each other")

CONTROLLER = Path(__file__).parent / "controller.py"
TOML = """
[ros]
stop = "/e_stop"
[robots.{robot}]
profile = "nao"
[profiles.nao]
step = 1
joint_states = "joint_states"
[profiles.nao.body.head]
left = {{ joint = "yaw", degrees = 30 }}
up = {{ joint = "pitch", degrees = 20 }}
[profiles.nao.body.arm]
up = {{ joint = "elbow", degrees = 30 }}
[profiles.nao.body.hand]
up = {{ joint = "wrist", degrees = 30 }}
[profiles.nao.joints.pitch]
max = 30
[profiles.nao.controllers.head]
joints = ["yaw", "pitch"]
[profiles.nao.controllers.arm]
joints = ["elbow"]
interface = "position"
[profiles.nao.controllers.hand]
joints = ["wrist"]
interface = "velocity"
"""
NO_STATES = TOML.replace('joint_states = "joint_states"', "")
FAST = "".join(f"[profiles.nao.joints.{joint}]\nmax_velocity = 50\n" for joint in ("yaw", "elbow", "wrist"))
HOME = TOML.replace("step = 1", 'step = 1\nhome = "move"').replace('"velocity"', '"position"') + FAST
HOME = HOME.replace("max = 30", "max = 30\nmax_velocity = 50")
"""Joints move to their starts at 10° a second."""
TURNS = "{robot} $ repeat (head left || arm up || hand up)\n"
MOVING = ("yaw", "elbow", "wrist")
RESTING = 25
"""How many messages must say the same: half a second of them."""
_names = count()


class Dance:
    """Somebody plays a program with `improv play` for a robot whose joints are listened to."""

    def __init__(self, folder: Path, env: Mapping[str, str], program: str, toml: str, host: Host | None = None) -> None:
        self.robot = f"ada{next(_names)}"
        (folder / "improv.toml").write_text(toml.format(robot=self.robot))
        path = folder / "dance.improv"
        path.write_text(program.format(robot=self.robot))
        command = [sys.executable, "-m", "improv_core", "play", "--backend", "ros", str(path)]
        pipe = subprocess.PIPE
        command = host.command(*command) if host else command
        self.process = subprocess.Popen(command, env={**env}, stdin=subprocess.DEVNULL, stderr=pipe, text=True)

    @property
    def stage(self) -> int:
        return next(iter(players(self.process.pid)))

    def wait_for_line(self, part: str) -> str:
        assert self.process.stderr
        return next(line for line in self.process.stderr if part in line)

    def close(self) -> None:
        self.process.send_signal(signal.SIGCONT)
        self.process.terminate()
        self.process.communicate(timeout=LIMIT)


def arguments_of(toml: str) -> list[str]:
    """What the controllers of a robot are started with."""
    hand = "velocity" if '"velocity"' in toml else "position"
    made = ["head trajectory yaw pitch", "arm position elbow", f"hand {hand} wrist"]
    return [word for each in made for word in ("--controller", *each.split())]


Begin = Callable[..., tuple[Dance, Listener]]


@pytest.fixture
def begin(
    script: Script, listen: Listen, ros_env: dict[str, str], tmp_path: Path, where: int | None
) -> Iterator[Begin]:
    """Plays a program: `begin(TURNS, start=("yaw", "0.5"))`. Each robot has a name of its own."""
    env = ros_env if where is None else {**ros_env, "ROS_DOMAIN_ID": str(where)}
    with ExitStack() as stack:

        def play(program: str, start: tuple[str, str] = ("yaw", "0"), toml: str = TOML) -> tuple[Dance, Listener]:
            dance = Dance(tmp_path, env, program, toml)
            stack.callback(dance.close)
            joints = listen(f"/{dance.robot}/joint_states", type="sensor_msgs/JointState")
            script(CONTROLLER, dance.robot, *arguments_of(toml), "--start", *start, ROS_DOMAIN_ID=env["ROS_DOMAIN_ID"])
            return dance, joints

        yield play


def moving(message: Mapping[str, Any]) -> bool:
    return all(message["positions"][joint] > 0.2 for joint in MOVING)


def rest(joints: Listener, *names: str) -> dict[str, float]:
    """Wait until these joints rest, or all; where all are."""
    same: list[Any] = []

    def rests(message: Mapping[str, Any]) -> bool:
        where = {name: at for name, at in message["positions"].items() if not names or name in names}
        if same and same[-1] != where:
            same.clear()
        same.append(where)
        return len(same) >= RESTING

    return dict(joints.wait(rests)["positions"])


def test_joints_move_as_the_program_says_and_stop_at_their_limits(begin: Begin) -> None:
    dance, joints = begin(
        "{robot} $ fast 2 (head (left left right || up up up) || arm (up up down) || hand (up up down))\n"
    )
    joints.wait(moving)
    assert dance.process.wait(LIMIT) == 0
    where = rest(joints)
    assert where["yaw"] == pytest.approx(radians(30))
    assert where["pitch"] == pytest.approx(radians(30))
    assert where["elbow"] == pytest.approx(radians(30))
    assert where["wrist"] > 0, "velocities are as exact as the times at which they come"


FAULTS: dict[str, Callable[[Dance], None]] = {
    "stage killed": lambda dance: os.kill(dance.stage, signal.SIGKILL),
    "stage halted": lambda dance: os.kill(dance.stage, signal.SIGSTOP),
    "parent halted": lambda dance: dance.process.send_signal(signal.SIGSTOP),
    "ended": lambda dance: dance.process.terminate(),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_whatever_fails_joints_come_to_rest(fault: str, begin: Begin, alone: Mapping[str, str]) -> None:
    dance, joints = begin(TURNS)
    joints.wait(moving)
    FAULTS[fault](dance)
    rest(joints)


def test_an_emergency_stop(begin: Begin, publish: Publish) -> None:
    pressed = publish("/e_stop", "std_msgs/Bool")
    pressed({"data": False})
    dance, joints = begin(TURNS)
    joints.wait(moving)
    pressed({"data": True})
    dance.wait_for_line("the emergency stop on /e_stop is on")
    rest(joints)


def test_nothing_moves_until_all_joints_are_at_their_starts(begin: Begin, publish: Publish) -> None:
    """Somebody turns the elbow back."""
    dance, joints = begin(TURNS, start=("elbow", "0.5"))
    line = dance.wait_for_line("nothing moves until all joints are at their starts")
    assert line.endswith(f"turn elbow of {dance.robot} by -29°\n")
    assert rest(joints) == {"yaw": 0, "pitch": 0, "elbow": 0.5, "wrist": 0}
    somebody = publish(f"/{dance.robot}/arm_controller/commands", "std_msgs/Float64MultiArray")
    somebody({"data": [0.0]})
    joints.wait(lambda message: message["positions"]["elbow"] == 0)
    somebody(None)
    joints.wait(moving)


def test_nothing_moves_if_nobody_says_where_joints_are(begin: Begin) -> None:
    dance, joints = begin(TURNS, toml=NO_STATES)
    dance.wait_for_line(f"nothing moves: it isn't known where the joints of {dance.robot} are: set `joint_states`")
    assert not any(rest(joints).values())


def test_joints_move_to_their_starts_first(begin: Begin) -> None:
    dance, joints = begin("{robot} $ head left || arm up\n", start=("yaw", "-0.6"), toml=HOME)
    line = dance.wait_for_line("joints move to their starts first")
    assert line.endswith(f": yaw of {dance.robot} by +34°\n")
    joints.wait(lambda message: -0.5 < message["positions"]["yaw"] < 0)
    joints.wait(lambda message: message["positions"]["elbow"] > 0)
    assert dance.process.wait(LIMIT) == 0
    assert rest(joints) == pytest.approx({"yaw": radians(30), "pitch": 0, "elbow": radians(30), "wrist": 0})


def test_an_emergency_stop_while_joints_move_to_their_starts(begin: Begin, publish: Publish) -> None:
    pressed = publish("/e_stop", "std_msgs/Bool")
    pressed({"data": False})
    dance, joints = begin(TURNS, start=("yaw", "-1.5"), toml=HOME)
    joints.wait(lambda message: message["positions"]["yaw"] > -1.4)
    pressed({"data": True})
    dance.wait_for_line("the emergency stop on /e_stop is on")
    where = rest(joints)
    assert where["yaw"] < 0
    assert where["elbow"] == 0


def test_trajectories_end_at_rest_if_the_network_is_gone(
    ros_python: str, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    """Nobody can help joints that a velocity controller moves: docs/ros.md says so, and `improv doctor`."""
    with ExitStack() as stack:
        there, here = stack.enter_context(on_one_link())
        env = {**ros_env, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4"}
        dance = Dance(tmp_path, env, TURNS, TOML, here)
        stack.callback(dance.close)
        others = Others(there.wrapper(ros_python, tmp_path), env)
        stack.callback(others.close)
        joints = Listener(others, f"/{dance.robot}/joint_states", type="sensor_msgs/JointState")
        command = there.command(ros_python, str(CONTROLLER), dance.robot, *arguments_of(TOML))
        robot = subprocess.Popen(command, env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        stack.callback(robot.communicate, timeout=LIMIT)
        joints.wait(moving)
        set_link(there, up=False)
        rest(joints, "yaw", "elbow")
        at = joints.wait(moving)["positions"]
        assert joints.wait(moving)["positions"]["wrist"] > at["wrist"]
