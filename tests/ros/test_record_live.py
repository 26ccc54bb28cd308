"""The recording of a real run on ROS 2, compared with the messages of a real subscriber."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.processes import descendants, wait_until_gone
from tests.recordings import Message, Velocity, read, topics
from tests.ros.conftest import LIMIT, STAMPED, Listen, Listener, with_limits
from tests.ros.dance import moving, still

pytestmark = pytest.mark.slow("starts what plays and records")

TOPIC = "/turtle1/cmd_vel"
CLOCKS = 0.01
"""Seconds by which two readings of clocks may differ."""
STILL = (0.0, 0.0, 0.0, 0.0)
Record = Callable[[str, Mapping[str, str]], "subprocess.Popen[str]"]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "dance.mcap"


@pytest.fixture
def record(path: Path) -> Iterator[Record]:
    """Start to play and to record a program."""
    processes: list[subprocess.Popen[str]] = []

    def start(program: str, env: Mapping[str, str]) -> subprocess.Popen[str]:
        source = path.with_name("dance.improv")
        source.write_text(program)
        command = [sys.executable, "-m", "improv_core", "record", "--backend", "ros", str(source), "-o", str(path)]
        processes.append(subprocess.Popen(command, env=env, stdout=subprocess.PIPE, text=True))
        return processes[-1]

    yield start
    for process in processes:
        process.kill()
        process.wait(LIMIT)


def hear_the_end(listener: Listener) -> None:
    """Wait for the three zeros that end every motion."""
    for _ in range(3):
        listener.wait(still)


def same(listener: Listener, messages: list[Message]) -> None:
    """Check that the listener heard the recorded velocities in the same order, and no earlier than recorded.

    Before them, a listener may hear zeros that are pending from the previous test.
    """
    first = next(index for index, message in enumerate(listener.heard) if moving(message))
    heard_since = listener.heard[first:]
    assert [message.velocity for message in messages] == [_velocity(message) for message in heard_since]
    wall = time.time() - time.monotonic()
    for recorded, heard in zip(messages, heard_since, strict=True):
        assert recorded.time / 1e9 < heard["at"] + wall + CLOCKS


def test_a_recording_is_what_a_subscriber_heard(
    listen: Listen, record: Record, path: Path, ros_env: Mapping[str, str]
) -> None:
    """The robot takes stamps and has limits."""
    robot = '[robots.turtle1]\nprofile = "turtlebot3_burger"\nmessage = "TwistStamped"\n'
    path.with_name("improv.toml").write_text(robot)
    listener = listen(TOPIC, type=STAMPED)
    env = {**ros_env, **with_limits(player__subscribers__PATIENCE=LIMIT)}
    process = record("beat 90\nturtle1 $ (fast 3 forward [left right left]) || slow 5/2 left\n", env)
    out, _ = process.communicate(timeout=LIMIT)
    listener.wait(moving)  # the zeros before that only check that it hears
    hear_the_end(listener)
    messages = read(path)
    same(listener, messages)
    assert process.returncode == 0
    assert out.splitlines()[-1].startswith(f"{path}: 1 robot, {len(messages)} messages, ")
    assert max(message.velocity[0] for message in messages) == pytest.approx(0.22)
    assert topics(path)[TOPIC].msgtype == "geometry_msgs/msg/TwistStamped"


def test_a_stage_that_dies_leaves_a_complete_recording(
    listen: Listen, record: Record, path: Path, alone: Mapping[str, str]
) -> None:
    listener = listen(TOPIC)
    process = record("turtle1 $ repeat forward\n", alone)
    for _ in range(3):
        listener.wait(moving)
    stages = descendants(process.pid)
    stage, _ = stages
    os.kill(stage, signal.SIGKILL)
    wait_until_gone(stages, LIMIT)
    assert process.wait(LIMIT) == 2
    messages = read(path)
    assert messages[0].velocity == (2.0, 0.0, 0.0, 0.0)
    assert [message.velocity for message in messages[-3:]] == [STILL] * 3  # from the stage that took its place


def _velocity(message: dict[str, Any]) -> Velocity:
    return message["x"], message["y"], message["z"], message["yaw"]
