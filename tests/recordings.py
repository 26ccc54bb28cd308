"""Content of a recording, by a library that is unrelated to the one that writes it."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path
from typing import Any, NamedTuple

from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection
from rosbags.typesys import Stores, get_typestore

ROS = get_typestore(Stores.ROS2_JAZZY)
Velocity = tuple[float, float, float, float]


class Message(NamedTuple):
    """`time` and `stamp` in nanoseconds; only a TwistStamped has a stamp."""

    time: int
    topic: str
    velocity: Velocity
    stamp: int | None


def read(path: Path) -> list[Message]:
    """Read all commands, in the order of their times."""
    with AnyReader([path], default_typestore=ROS) as reader:
        return [
            _message(time, connection.topic, reader.deserialize(raw, connection.msgtype))
            for connection, time, raw in reader.messages()
            if connection.msgtype.startswith("geometry_msgs/msg/Twist")
        ]


class JointMessage(NamedTuple):
    """`time` in nanoseconds, and for each joint its position and velocity."""

    time: int
    topic: str
    joints: dict[str, tuple[float, float]]


def read_joints(path: Path) -> list[JointMessage]:
    """Read the motions of joints, in the order of the times. Each message is stamped with its time."""
    found = []
    with AnyReader([path], default_typestore=ROS) as reader:
        for connection, time, raw in reader.messages():
            if connection.msgtype == "sensor_msgs/msg/JointState":
                message: Any = reader.deserialize(raw, connection.msgtype)
                assert message.header.stamp.sec * 10**9 + message.header.stamp.nanosec == time
                assert (message.header.frame_id, list(message.effort)) == ("", [])
                motions = zip(map(float, message.position), map(float, message.velocity), strict=True)
                found.append(JointMessage(time, connection.topic, dict(zip(message.name, motions, strict=True))))
    return found


def topics(path: Path) -> dict[str, Connection]:
    with AnyReader([path], default_typestore=ROS) as reader:
        return {connection.topic: connection for connection in reader.connections}


def changes(messages: list[Message], topic: str) -> list[tuple[int, Velocity]]:
    """Return the times at which the velocity on a topic changed, and the new velocities."""
    own = (message for message in messages if message.topic == topic)
    groups = groupby(own, key=lambda message: message.velocity)
    return [(next(group).time, velocity) for velocity, group in groups]


def _message(time: int, topic: str, message: Any) -> Message:
    stamp = message.header.stamp if hasattr(message, "header") else None
    twist = message.twist if stamp else message
    assert (twist.angular.x, twist.angular.y) == (0, 0)
    velocity = twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.z
    return Message(time, topic, velocity, stamp.sec * 10**9 + stamp.nanosec if stamp else None)
