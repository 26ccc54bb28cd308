"""Messages that we serialize ourselves, beside those that rclpy serializes."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from improv_core.outputs.cdr import (
    SECOND,
    frame_field,
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
from geometry_msgs.msg import Twist, TwistStamped
from rclpy.serialization import deserialize_message, serialize_message

def values(velocity):
    return [getattr(vector, axis) for vector in (velocity.linear, velocity.angular) for axis in "xyz"]

for line in sys.stdin:
    plain, stamped = map(bytes.fromhex, json.loads(line))
    one, other = deserialize_message(plain, Twist), deserialize_message(stamped, TwistStamped)
    stamp = other.header.stamp
    again = serialize_message(one).hex(), len(serialize_message(other))
    print(json.dumps([values(one), values(other.twist), stamp.sec, stamp.nanosec, other.header.frame_id, *again]))
"""
"""A script that prints the fields that rclpy reads from pairs of messages, and the messages that it makes of them."""
TIME = 1_700_000_000 * SECOND + 123_456_789
TWISTS = [
    (STILL, ""),
    (Twist(0.25, -1e-300, 3.0, -1.5), "base_link"),
    (Twist(2, 0, -1, 7), "a/b"),
    (Twist(1e300, 5e-324, -0.0, 1 / 3), "odom-2x"),
]


def test_rclpy_reads_and_writes_the_same(ros_python: str, ros_env: dict[str, str]) -> None:
    pairs = [
        (plain := twist_message(twist), stamped(plain, TIME, frame_field(frame)))  # a Twist, and the same with a stamp
        for twist, frame in TWISTS
    ]
    read = subprocess.run(
        [ros_python, "-c", READ],
        input="".join(json.dumps([plain.hex(), made.hex()]) + "\n" for plain, made in pairs),
        env=ros_env,
        cwd=Path("/"),
        capture_output=True,
        text=True,
        check=True,
    )
    for (twist, frame), (plain, made), line in zip(TWISTS, pairs, read.stdout.splitlines(), strict=True):
        one, other, sec, nanosec, read_frame, again, length = json.loads(line)
        assert one == other == [twist.x, twist.y, twist.z, 0, 0, twist.yaw]
        assert (sec, nanosec, read_frame) == (1_700_000_000, 123_456_789, frame)
        assert frame_in(made) == frame
        assert again == plain.hex()
        assert length == len(made)  # the bytes between the frame and the velocity are arbitrary


READ_JOINTS = """
import json, sys
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory

trajectory, numbers, states = json.loads(sys.stdin.read())
read = deserialize_message(bytes.fromhex(trajectory), JointTrajectory)
points = [
    [each.time_from_start.sec + each.time_from_start.nanosec / 1e9, [*each.positions], [*each.velocities]]
    + [[*each.accelerations], [*each.effort]]
    for each in read.points
]
stamp = [read.header.stamp.sec, read.header.stamp.nanosec]
found = deserialize_message(bytes.fromhex(numbers), Float64MultiArray)
messages = []
for names, positions, frame in states:
    message = JointState(name=names, position=positions, velocity=[9.0] * len(names))
    message.header.frame_id, message.header.stamp.sec = frame, 7
    messages.append(serialize_message(message).hex())
print(json.dumps([[stamp, read.joint_names, points], [*found.data], [*found.layout.dim], messages]))
"""
"""A script that prints the fields of a trajectory and of numbers, and rclpy's messages with joint states."""


def test_rclpy_reads_joint_commands_and_we_read_joint_states(ros_python: str, ros_env: dict[str, str]) -> None:
    names = ("a", "bcd", "head_yaw")
    points = [(0.0, [1.0, -2.0, 3.5], [0.5, 0.0, -1e-9]), (0.3, [1.125, -2.0, 3.5], [0.0, 0.0, 0.0])]
    numbers = [1.5, -2.0, 1e-300]
    states = [
        (["a"], [1.5], "base"),
        (["a", "bcd", "head_yaw"], [1.0, -2.0, 3.25], ""),
        (["a", "b"], [1.0], "a name too many"),
        ([], [], ""),
        (["a", "b"], [float("nan"), 2.0], "odd"),
    ]
    sent = [trajectory_message(names, points).hex(), numbers_message(numbers).hex(), states]
    read = subprocess.run(
        [ros_python, "-c", READ_JOINTS],
        input=json.dumps(sent),
        env=ros_env,
        cwd=Path("/"),
        capture_output=True,
        text=True,
        check=True,
    )
    [stamp, joints, found], read_numbers, layout, messages = json.loads(read.stdout)
    assert (stamp, tuple(joints), read_numbers, layout) == ([0, 0], names, numbers, [])
    assert found == [[*each, [], []] for each in points]
    made = [bytes.fromhex(each) for each in messages]
    assert [joints_in(each) for each in made] == [
        {"a": 1.5},
        {"a": 1.0, "bcd": -2.0, "head_yaw": 3.25},
        {},
        {},
        {"b": 2.0},
    ]
    assert all(joints_in(each[:length]) == {} for each in made for length in range(4, len(each) // 2))
