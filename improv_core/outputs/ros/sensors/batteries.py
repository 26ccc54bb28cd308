"""Battery levels of robots from ROS topics (messages imported lazily)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from improv_core.outputs.ros.nodes import subscribe
from improv_core.outputs.ros.sensors.readings import battery


class RosBatteries:
    """Subscribes to the topics of robots' batteries on a node that an executor spins.

    `unread` gets each topic to which it can't subscribe, and a line with the reason.
    """

    def __init__(self, node: Any, unread: Callable[[str, str], None]) -> None:
        self._node = node
        self._unread = unread
        self._robots: dict[str, list[str]] = {}  # by topic
        self._made: dict[str, Any] = {}
        self._new: dict[str, float] = {}

    def keep(self, topics: Mapping[str, str]) -> None:
        """Subscribe to the topics of these robots, and to no others."""
        self._robots = {}
        for robot, topic in topics.items():
            self._robots.setdefault(topic, []).append(robot)
        for topic in self._made.keys() - self._robots.keys():
            if made := self._made.pop(topic):
                self._node.destroy_subscription(made)
        for topic in self._robots.keys() - self._made.keys():
            self._made[topic] = self._subscribe(topic)

    def take(self) -> dict[str, float]:
        """The battery levels, from 0 to 1, that arrived since the last call."""
        new, self._new = self._new, {}
        return new

    def _subscribe(self, topic: str) -> Any:
        """Create a subscription; None if that is impossible."""

        def take(received: Any) -> None:
            if (share := battery(received)) is not None:
                self._new.update(dict.fromkeys(self._robots.get(topic, ()), share))

        try:
            from rclpy.qos import qos_profile_sensor_data
            from sensor_msgs.msg import BatteryState

            return subscribe(self._node, BatteryState, topic, take, qos_profile_sensor_data)
        except Exception as error:  # rclpy raises many exceptions, such as for a topic on which we use another type
            self._unread(topic, f"{topic} can't be read as sensor_msgs/BatteryState: {error}")
        return None
