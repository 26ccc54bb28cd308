"""Velocities to ROS 2 topics, from one node that lives as long as the stage (rclpy, imported lazily)."""

from __future__ import annotations

import math
import os
import time
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
SETTLE = 0.2
"""Seconds until a match counts: the listener's side follows ours, and until then a command came up to 0.16 s late."""
LINGER = 0.2
"""Seconds to keep the publishers after the last zeros: a listener loses what it has not received when they go."""


class Ros:
    """A sink that publishes `geometry_msgs/Twist`, or `TwistStamped` to topics whose listeners want only that.

    `discovery` is used where the environment says nothing: by default other machines do not see us, so that nobody
    moves a neighbor's robot. Raises ImportError where rclpy can't be had.
    """

    name: str = "ROS 2"
    period: float | None = None

    def __init__(self, discovery: str | None) -> None:
        # Set but empty, it would mean the subnet (rcl, discovery_options.c).
        os.environ[DISCOVERY] = os.environ.get(DISCOVERY) or discovery or "LOCALHOST"
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
        reach = REACH.get(os.environ[DISCOVERY], REACH["LOCALHOST"])  # what rcl makes of a value it does not know
        return f"{self.name}, domain {os.environ.get('ROS_DOMAIN_ID') or 0}, {reach}"

    def prepare(self, parts: Mapping[str, Part], restart: bool) -> None:
        """Make publishers for new topics; those that are there are kept, since discovery takes up to seconds."""
        self._cast = list(parts)
        for robot, part in parts.items():
            self._topics[robot] = part.topic
            if part.topic not in self._publishers:
                # A score that takes over can't wait: whoever is matched at once counts as there.
                unheard = time.monotonic() if restart else -math.inf
                self._publishers[part.topic] = _Publisher(self._node, part.topic, unheard)

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

        time.sleep(LINGER)
        self._node.destroy_node()
        rclpy.try_shutdown()


class _Publisher:
    """One topic's publisher, of the type that its listeners want; `unheard` is when it was last without any."""

    def __init__(self, node: Any, topic: str, unheard: float) -> None:
        from geometry_msgs.msg import Twist as TwistMessage
        from geometry_msgs.msg import TwistStamped

        self._node = node
        self._topic = topic
        self._types = {"geometry_msgs/msg/Twist": TwistMessage, "geometry_msgs/msg/TwistStamped": TwistStamped}
        self._unheard = unheard
        self._use(TwistMessage)

    def is_heard(self) -> bool:
        """Whether a listener is matched, and settled; one that wants the other type is served from now on."""
        now = time.monotonic()
        if self._publisher.get_subscription_count():
            return now >= self._unheard + SETTLE
        self._unheard = now
        # Listeners of another type never match, but the graph tells what they want.
        listeners = self._node.get_subscriptions_info_by_topic(self._topic)
        wanted = [self._types[listener.topic_type] for listener in listeners if listener.topic_type in self._types]
        if wanted and self._type not in wanted:
            self._node.destroy_publisher(self._publisher)
            self._use(wanted[0])
        return False

    def publish(self, twist: Twist) -> None:
        message = self._type()
        velocity = message
        if "Stamped" in self._type.__name__:
            message.header.stamp = self._node.get_clock().now().to_msg()
            velocity = message.twist
        # An int would not be refused: rclpy reads its memory as a float64, about 0.
        velocity.linear.x, velocity.linear.y, velocity.linear.z = float(twist.x), float(twist.y), float(twist.z)
        velocity.angular.z = float(twist.yaw)
        self._publisher.publish(message)

    def _use(self, message_type: Any) -> None:
        from rclpy.qos import QoSProfile

        self._type = message_type
        self._publisher = self._node.create_publisher(message_type, self._topic, QoSProfile(depth=DEPTH))
