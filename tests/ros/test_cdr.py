"""Messages that we serialize ourselves, beside those that rclpy serializes."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from improv_core.outputs.cdr import (
    SECOND,
    frame_in,
    joints_in,
    numbers_message,
    stamped,
    trajectory_message,
    twist_message,
)
from improv_core.score.motion import STILL, Twist

pytestmark = pytest.mark.slow("starts ROS's interpreter")

READ = """
import json, sys
from importlib import import_module
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

def plain(value):
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    return value if isinstance(value, str | float | int) else [plain(each) for each in value]

messages, states = json.load(sys.stdin)
read = []
for name, data in messages:
    package, _, kind = name.partition("/")
    message = deserialize_message(bytes.fromhex(data), getattr(import_module(f"{package}.msg"), kind))
    read.append([plain(message), serialize_message(message).hex()])
made = []
for names, positions, frame in states:
    message = JointState(name=names, position=positions, velocity=[9.0] * len(names))
    message.header.frame_id, message.header.stamp.sec = frame, 7
    made.append(serialize_message(message).hex())
print(json.dumps([read, made]))
"""
"""A script that prints the fields that rclpy reads from messages, what it makes of them again, and its joint states."""

State = tuple[list[str], list[float], str]
"""Names, positions, and a frame."""
Rclpy = Callable[..., tuple[list[Any], list[bytes]]]
TIME = 1_700_000_000 * SECOND + 123_456_789
TWISTS = [
    (STILL, ""),
    (Twist(0.25, -1e-300, 3.0, -1.5), "base_link"),
    (Twist(2, 0, -1, 7), "a/b"),
    (Twist(1e300, 5e-324, -0.0, 1 / 3), "odom-2x"),
]


@pytest.fixture
def rclpy(ros_python: str, ros_env: dict[str, str]) -> Rclpy:
    """Return a function that returns what rclpy reads from messages and makes of them, and its own joint states."""

    def run(messages: Sequence[tuple[str, bytes]], states: Sequence[State] = ()) -> tuple[list[Any], list[bytes]]:
        sent = json.dumps([[(name, data.hex()) for name, data in messages], states])
        command = [ros_python, "-c", READ]
        done = subprocess.run(
            command, input=sent, env=ros_env, cwd=Path("/"), stdout=subprocess.PIPE, text=True, check=True
        )
        read, made = json.loads(done.stdout)
        return read, [bytes.fromhex(each) for each in made]

    return run


def test_rclpy_reads_and_writes_the_same(rclpy: Rclpy) -> None:
    plain = [twist_message(twist) for twist, _ in TWISTS]
    made = [stamped(each, TIME, frame) for each, (_, frame) in zip(plain, TWISTS, strict=True)]
    sent = [("geometry_msgs/Twist", each) for each in plain] + [("geometry_msgs/TwistStamped", each) for each in made]
    read = rclpy(sent)[0]
    for number, (twist, frame) in enumerate(TWISTS):
        [one, again], [other, like] = read[number], read[number + len(TWISTS)]
        assert one == other["twist"]
        assert one["linear"] == {"x": twist.x, "y": twist.y, "z": twist.z}
        assert one["angular"] == {"x": 0, "y": 0, "z": twist.yaw}
        assert other["header"] == {"stamp": {"sec": 1_700_000_000, "nanosec": 123_456_789}, "frame_id": frame}
        assert frame_in(made[number]) == frame
        assert again == plain[number].hex()
        assert len(like) == len(made[number].hex())  # the bytes between the frame and the velocity are arbitrary


def test_rclpy_reads_joint_commands_and_we_read_joint_states(rclpy: Rclpy) -> None:
    names = ["a", "bcd", "head_yaw"]
    points = [(0.0, [1.0, -2.0, 3.5], [0.5, 0.0, -1e-9]), (0.3, [1.125, -2.0, 3.5], [0.0, 0.0, 0.0])]
    numbers = [1.5, -2.0, 1e-300]
    states: list[tuple[State, dict[str, float]]] = [
        ((["a"], [1.5], "base"), {"a": 1.5}),
        ((names, [1.0, -2.0, 3.25], ""), {"a": 1.0, "bcd": -2.0, "head_yaw": 3.25}),
        ((["a", "b"], [1.0], "a name too many"), {}),
        (([], [], ""), {}),
        ((["a", "b"], [float("nan"), 2.0], "odd"), {"b": 2.0}),
    ]
    commands = [
        ("trajectory_msgs/JointTrajectory", trajectory_message(tuple(names), points)),
        ("std_msgs/Float64MultiArray", numbers_message(numbers)),
    ]
    ([trajectory, _], [array, _]), made = rclpy(commands, [state for state, _ in states])
    assert trajectory["header"]["stamp"] == {"sec": 0, "nanosec": 0}
    assert trajectory["joint_names"] == names
    empty: dict[str, list[float]] = {"accelerations": [], "effort": []}
    assert trajectory["points"] == [
        {"positions": positions, "velocities": velocities, "time_from_start": {"sec": 0, "nanosec": at * 1e9}, **empty}
        for at, positions, velocities in points
    ]
    assert (array["data"], array["layout"]["dim"]) == (numbers, [])
    assert [joints_in(each) for each in made] == [read for _, read in states]
    assert all(joints_in(each[:length]) == {} for each in made for length in range(4, len(each) // 2))
