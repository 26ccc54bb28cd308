"""`improv doctor` with ROS 2: it sees who is there, and tells no robot anything."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest

from tests.ros.conftest import LIMIT, Listener

TELEOP = """
import sys, rclpy
from geometry_msgs.msg import Twist
rclpy.init()
node = rclpy.create_node("teleop")
node.create_publisher(Twist, sys.argv[1], 10)
print(flush=True)
sys.stdin.read()
"""
TOML = """
[robots.anna]
topic = "/lab/anna"
[robots.bert]
topic = "/lab/bert"
[robots.carl]
topic = "/lab/carl"
message = "Twist"
"""


@pytest.fixture
def teleop(ros_python: str, ros_env: Mapping[str, str]) -> Iterator[None]:
    """Somebody else who publishes for anna."""
    process = subprocess.Popen(
        [ros_python, "-c", TELEOP, "/lab/anna"], env=ros_env, stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    assert process.stdout
    process.stdout.readline()
    yield
    process.communicate(timeout=LIMIT)


def doctor(env: Mapping[str, str], folder: Path, *arguments: str) -> tuple[int, list[str]]:
    command = [sys.executable, "-m", "improv_core", "doctor", *arguments]
    done = subprocess.run(command, env=env, cwd=folder, capture_output=True, text=True, encoding="utf-8", timeout=LIMIT)
    assert done.stderr == ""
    return done.returncode, done.stdout.splitlines()


@pytest.mark.usefixtures("teleop")
def test_it_sees_who_is_there(
    ros_env: dict[str, str], ros_python: str, listen: Callable[..., Listener], tmp_path: Path
) -> None:
    listener, _ = listen("/lab/anna"), listen("/lab/carl", "--stamped")
    (tmp_path / "improv.toml").write_text(TOML)
    expected = [
        "✓ anna: /listener listens for Twist on /lab/anna",
        "– anna: /teleop also publishes on /lab/anna: stop it while Improv plays, or the robot obeys both and stutters",
        "– bert: nothing is listening on /lab/bert: start the robot",
        "✗ carl: /listener listens for TwistStamped on /lab/carl, not Twist: "
        'set `message = "auto"` for it in improv.toml',
    ]
    end = time.monotonic() + LIMIT
    while True:  # on a busy machine, discovery may take longer than it looks
        code, lines = doctor(ros_env, tmp_path)
        seen = [line for line in lines if line[2:6] in ("anna", "bert", "carl")]
        if seen == expected or time.monotonic() > end:
            break
    assert seen == expected
    assert code == 1
    assert f"from IMPROV_ROS_PYTHON: {ros_python}" in "\n".join(lines)
    domain = ros_env["ROS_DOMAIN_ID"]
    assert any(line.startswith(f"✓ domain {domain}, this machine only: ") for line in lines)
    assert "✓ the standby, which stops robots if the process that moves them dies" in lines
    assert listener.heard == []


def test_only_the_robots_of_the_program(ros_env: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "improv.toml").write_text(TOML)
    (tmp_path / "dance.improv").write_text("bert $ forward\n")
    code, lines = doctor(ros_env, tmp_path, "dance.improv")
    assert code == 0
    assert [line for line in lines if "/lab/" in line] == ["– bert: nothing is listening on /lab/bert: start the robot"]


def test_a_domain_that_is_none(ros_env: dict[str, str], tmp_path: Path) -> None:
    code, lines = doctor({**ros_env, "ROS_DOMAIN_ID": "lab"}, tmp_path)
    assert code == 1
    assert "✗ ROS_DOMAIN_ID is lab: set it to a number from 0 to 101" in lines


def test_a_ros_that_does_not_start(ros_env: dict[str, str], tmp_path: Path) -> None:
    code, lines = doctor({**ros_env, "ROS_SECURITY_ENABLE": "true", "ROS_SECURITY_STRATEGY": "Enforce"}, tmp_path)
    assert code == 1
    assert any(line.startswith("✗ ROS 2 does not start (") for line in lines)
