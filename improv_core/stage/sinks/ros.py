"""Velocities to ROS 2 topics, from one node that lives as long as the stage (rclpy, imported lazily)."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from improv_core.motion import Pose, Twist
from improv_core.score import Part

DISCOVERY = "ROS_AUTOMATIC_DISCOVERY_RANGE"
REACH = {
    "LOCALHOST": "this machine only",
    "SUBNET": "the whole subnet",
    "OFF": "no discovery",
    "SYSTEM_DEFAULT": "the system's own reach",
}
DEPTH = 10
"""Messages kept for a slow listener, reliably: as teleop_twist_keyboard and Nav2 publish, so all listeners match."""


class Ros:
    """A sink that publishes `geometry_msgs/Twist`, or `TwistStamped` to topics whose listeners want only that.

    `discovery` is used where the environment says nothing: by default other machines do not see us, so that nobody
    moves a neighbor's robot. Raises ImportError where rclpy can't be had.
    """

    name: str = "ROS 2"
    period: float | None = None

    def __init__(self, discovery: str | None) -> None:
        os.environ.setdefault(DISCOVERY, discovery or "LOCALHOST")
        import rclpy
        from rclpy.signals import SignalHandlerOptions

        # rclpy's own handlers would invalidate the context before the last zero could be sent.
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        self._node: Any = rclpy.create_node("improv")
        self._topics: dict[str, str] = {}
        self._publishers: dict[str, _Publisher] = {}
        self._cast: list[str] = []

    @property
    def description(self) -> str:
        """What is reached, in words: the domain and how far discovery goes."""
        reach = os.environ[DISCOVERY]
        return f"{self.name}, domain {os.environ.get('ROS_DOMAIN_ID') or 0}, {REACH.get(reach, reach)}"

    def prepare(self, parts: Mapping[str, Part], restart: bool) -> None:
        """Make publishers for new topics; those that are there are kept, since discovery takes up to seconds."""
        self._cast = list(parts)
        for robot, part in parts.items():
            self._topics[robot] = part.topic
            if part.topic not in self._publishers:
                self._publishers[part.topic] = _Publisher(self._node, part.topic)

    def missing(self) -> dict[str, str]:
        topics = {robot: self._topics[robot] for robot in self._cast}
        return {
            robot: f"nobody listens on {topic} ({self.description})"
            for robot, topic in topics.items()
            if not self._publishers[topic].is_heard()
        }

    def send(self, robot: str, twist: Twist, at: float) -> None:
        """Publish at once. What rclpy raises goes up: the stage then stops all robots."""
        self._publishers[self._topics[robot]].publish(twist)

    def advance(self, to: float) -> None:
        """Nothing: robots move by themselves."""

    def poses(self) -> dict[str, Pose]:
        return {}

    def close(self) -> None:
        import rclpy

        self._node.destroy_node()
        rclpy.try_shutdown()


class _Publisher:
    """One topic's publisher, of the type that its listeners want."""

    def __init__(self, node: Any, topic: str) -> None:
        from geometry_msgs.msg import Twist as TwistMessage
        from geometry_msgs.msg import TwistStamped

        self._node = node
        self._topic = topic
        self._types = {"geometry_msgs/msg/Twist": TwistMessage, "geometry_msgs/msg/TwistStamped": TwistStamped}
        self._use(TwistMessage)

    def is_heard(self) -> bool:
        """Whether a listener is matched; one that wants the other type is served from now on."""
        if self._publisher.get_subscription_count():
            return True
        # Listeners of another type never match, but the graph tells what they want.
        for listener in self._node.get_subscriptions_info_by_topic(self._topic):
            wanted = self._types.get(listener.topic_type)
            if wanted and wanted is not self._type:
                self._node.destroy_publisher(self._publisher)
                self._use(wanted)
                break
        return False

    def publish(self, twist: Twist) -> None:
        message = self._type()
        velocity = message
        if "Stamped" in self._type.__name__:
            message.header.stamp = self._node.get_clock().now().to_msg()
            velocity = message.twist
        velocity.linear.x, velocity.linear.y, velocity.linear.z = twist.x, twist.y, twist.z
        velocity.angular.z = twist.yaw
        self._publisher.publish(message)

    def _use(self, message_type: Any) -> None:
        from rclpy.qos import QoSProfile

        self._type = message_type
        self._publisher = self._node.create_publisher(message_type, self._topic, QoSProfile(depth=DEPTH))
