"""The subscriptions of the process that reads sensors (rclpy and messages imported lazily)."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from improv_core.outputs.ros.nodes import Nodes, is_published
from improv_core.outputs.ros.sensors.polled import PolledTopics, Unread, try_subscribe
from improv_core.outputs.ros.sensors.poses import KINDS
from improv_core.outputs.ros.sensors.readings import holds
from improv_core.score.senses import Message, Topic

BATTERY = "sensor_msgs/BatteryState"
JOINT_STATE = "sensor_msgs/JointState"
JOINTS_PERIOD = 0.05
"""Seconds between reads of joint states, which controllers may send a thousand times a second."""
JOINTS_KEPT = 5
"""The number of messages kept of a topic: each of several controllers may send the positions of its own joints."""
HearTopic = Callable[[Topic, bool | None], None]


class Subscriptions:
    """Subscribes to topics, each once, and passes on the values of the senses in each message.

    `arguments` are ROS's own. The caller takes the messages about `poses`, `batteries`, and `joint_states`.
    """

    def __init__(self, node: str, arguments: Sequence[str], hear: HearTopic, unread: Unread) -> None:
        self._hear = hear
        self._unread = unread
        from rclpy.parameter import Parameter

        # A thousand messages a second on /clock would wake this process, which needs no time.
        untimed = [Parameter("use_sim_time", value=False)]
        options = {"start_parameter_services": False, "enable_rosout": False, "parameter_overrides": untimed}
        self._nodes = Nodes(node, arguments, **options)
        self._node = self._nodes.first
        self._executor = _executor(self._node.context)
        self._executor.add_node(self._node)
        self._polling: Any = None  # a node, once it is needed
        self.poses = PolledTopics(self._polling_node, unread, KINDS)
        self.batteries = PolledTopics(self._polling_node, unread, {BATTERY: 1}, raw=False)
        joints = {JOINT_STATE: JOINTS_KEPT}
        self.joint_states = PolledTopics(self._polling_node, unread, joints, period=JOINTS_PERIOD)
        self._made: dict[tuple[str, Message], Any] = {}
        self._heard: dict[tuple[str, Message], list[Topic]] = {}

    def keep(self, topics: Iterable[Topic]) -> None:
        """Subscribe to these topics, and to no others."""
        self._heard = {}
        for topic in topics:
            self._heard.setdefault((topic.topic, topic.message), []).append(topic)
        for key in self._made.keys() - self._heard.keys():
            if made := self._made.pop(key):
                self._node.destroy_subscription(made)
        for name, message in self._heard.keys() - self._made.keys():
            self._made[name, message] = self._subscribe(name, message)

    def spin(self, seconds: float) -> None:
        """Receive the messages that arrive within this many seconds."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            self._executor.spin_once(timeout_sec=left)

    def is_published(self, topic: str) -> bool:
        return is_published(self._node, topic)

    def close(self) -> None:
        self._executor.shutdown()
        if self._polling:
            self._polling.destroy_node()
        self._nodes.close()

    def _polling_node(self) -> Any:
        """Return the node without an executor."""
        if not self._polling:
            import rclpy

            options = {"start_parameter_services": False, "enable_rosout": False}
            name = f"{self._node.get_name()}_polling"
            self._polling = rclpy.create_node(name, context=self._node.context, **options)
        return self._polling

    def _subscribe(self, name: str, message: Message) -> Any:
        """Create a subscription; None if that is impossible."""
        from rclpy.qos import qos_profile_sensor_data

        def take(received: Any) -> None:
            for topic in self._heard.get((name, message), ()):
                self._hear(topic, holds(topic, received))

        return try_subscribe(self._node, message, name, take, qos_profile_sensor_data, self._unread)


def _executor(context: Any) -> Any:
    """Create an executor. Since Jazzy there is one that takes a message in a quarter of the time.

    Subscriptions with callbacks for events can crash it (rclpy#1644); ours have none.
    """
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:
        from rclpy.executors import SingleThreadedExecutor

        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)
