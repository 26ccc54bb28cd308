"""Messages that we serialize ourselves, beside those that rclpy serializes."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from improv_core.score.motion import STILL, Twist
from improv_core.stage.sinks.cdr import SECOND, frame_field, frame_in, stamped, twist_message

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
"""Prints what rclpy finds in pairs of messages, and what it makes of that."""
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
        assert length == len(made)  # the bytes between the frame and the velocity are whatever rclpy finds there
