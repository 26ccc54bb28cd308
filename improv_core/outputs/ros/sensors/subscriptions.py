"""The subscriptions of the process that reads sensors (rclpy and messages imported lazily)."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable
from importlib import import_module
from typing import Any

from improv_core.outputs.ros.nodes import Nodes, subscribe
from improv_core.outputs.ros.sensors.batteries import RosBatteries
from improv_core.outputs.ros.sensors.joint_states import RosJointStates
from improv_core.outputs.ros.sensors.poses import RosPoses
from improv_core.outputs.ros.sensors.readings import holds
from improv_core.score.senses import Message, Topic

Hear = Callable[[Topic, bool | None], None]


class Subscriptions:
    """Subscribes to topics, each once, and passes on the values of the senses in each message.

    `unread` gets each topic to which it can't subscribe, and a line with the reason.
    """

    def __init__(self, node: str, hear: Hear, unread: Callable[[str, str], None]) -> None:
        self._hear = hear
        self._unread = unread
        self._nodes = Nodes(node, start_parameter_services=False, enable_rosout=False)
        self._node = self._nodes.first
        self._executor = _executor(self._node.context)
        self._executor.add_node(self._node)
        self.poses = RosPoses(lambda: self._node_without_executor("poses"), unread)
        """The poses of robots. The caller takes them."""
        self.batteries = RosBatteries(self._node, unread)
        """The battery levels of robots. The caller takes them."""
        self.joint_states = RosJointStates(lambda: self._node_without_executor("joints"), unread)
        """The positions of robots' joints. The caller takes them."""
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
        """Return whether a topic has a publisher."""
        return bool(self._node.count_publishers(topic))

    def close(self) -> None:
        """Destroy all nodes."""
        self._executor.shutdown()
        self.poses.close()
        self.joint_states.close()
        self._nodes.close()

    def _node_without_executor(self, what: str) -> Any:
        import rclpy

        name = f"{self._node.get_name()}_{what}"
        options = {"start_parameter_services": False, "enable_rosout": False}
        return rclpy.create_node(name, context=self._node.context, **options)

    def _subscribe(self, name: str, message: Message) -> Any:
        """Create a subscription; None if that is impossible."""
        package, _, kind = message.partition("/")

        def take(received: Any) -> None:
            for topic in self._heard.get((name, message), ()):
                self._hear(topic, holds(topic, received))

        try:
            from rclpy.qos import qos_profile_sensor_data

            found = getattr(import_module(f"{package}.msg"), kind)
            return subscribe(self._node, found, name, take, qos_profile_sensor_data)
        except ImportError:
            self._unread(name, f"{sys.executable} can't import {package}, so {name} can't be read: install {package}")
        except Exception as error:  # rclpy raises many exceptions, such as for a topic on which we use another type
            self._unread(name, f"{name} can't be read as {message}: {error}")
        return None


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
