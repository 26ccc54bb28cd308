"""The positions of robots' joints from ROS topics (rclpy and messages imported lazily).

Controllers send them up to a thousand times a second. Only messages that are used are taken, as with poses.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any

from improv_core.outputs.cdr import joints_in
from improv_core.outputs.ros.nodes import subscribe
from improv_core.protocol.output import RawJoints

PERIOD = 0.05
"""Seconds between two looks at a topic."""
DEPTH = 5
"""The number of messages kept of a topic: each of several controllers may send the positions of its own joints."""


class RosJointStates:
    """Subscribes to sensor_msgs/JointState, on a node without an executor. `unread` gets each topic to which it can't
    subscribe, and a line with the reason."""

    def __init__(self, node: Callable[[], Any], unread: Callable[[str, str], None]) -> None:
        self._make_node = node
        self._node: Any = None
        self._unread = unread
        self._robots: dict[str, list[str]] = {}  # by topic
        self._made: dict[str, Any] = {}
        self._due = 0.0

    def keep(self, topics: Mapping[str, str]) -> None:
        """Subscribe to the topics of these robots, and to no others."""
        self._robots = {}
        for robot, topic in topics.items():
            self._robots.setdefault(topic, []).append(robot)
        for topic in self._made.keys() - self._robots.keys():
            if made := self._made.pop(topic):
                self._node.destroy_subscription(made)
        for topic in self._robots.keys() - self._made.keys():
            self._node = self._node or self._make_node()
            self._made[topic] = self._subscribe(topic)

    def take(self) -> list[RawJoints]:
        """The new positions of each robot's joints, at most twenty times a second."""
        now = time.monotonic()
        if not self._made or now < self._due:
            return []
        self._due = now + PERIOD
        found = []
        for topic, subscription in self._made.items():
            positions: dict[str, float] = {}
            while subscription and (taken := _take(subscription)):
                positions |= joints_in(taken[0])
            if positions:
                found += [RawJoints(robot, positions, now) for robot in self._robots[topic]]
        return found

    def close(self) -> None:
        """Destroy the node."""
        if self._node:
            self._node.destroy_node()

    def _subscribe(self, topic: str) -> Any:
        """Create a subscription; None if that is impossible."""
        try:
            from rclpy.qos import QoSProfile, ReliabilityPolicy
            from sensor_msgs.msg import JointState

            qos = QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT)
            return subscribe(self._node, JointState, topic, lambda message: None, qos, raw=True)
        except Exception as error:  # rclpy raises many exceptions, such as for a topic on which we use another type
            self._unread(topic, f"{topic} can't be read as sensor_msgs/JointState: {error}")
        return None


def _take(subscription: Any) -> Any:
    with subscription.handle:
        return subscription.handle.take_message(subscription.msg_type, True)
