"""Inspection of the ROS 2 graph. It never publishes anything (rclpy, imported lazily). Standard library only.

ROS's interpreter runs it as `python …/improv_core/stage graph look TOPIC...`, `graph twists TOPIC`, or
`graph text TOPIC`.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib import import_module
from itertools import pairwise
from typing import Any

from improv_core.outputs.ros.nodes import is_latched, qualities_for
from improv_core.outputs.ros.sensors.readings import battery
from improv_core.protocol.fields import PoseJson
from improv_core.protocol.graph_messages import UNNAMED, Endpoint, Graph
from improv_core.protocol.json_lines import own_output

VELOCITIES = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")
"""The message types that move robots."""
POSES = ("nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped")
"""The message types of robots' poses."""
TF = "tf2_msgs/msg/TFMessage"
"""The message type of transforms, which show where robots are, too."""
BATTERY = "sensor_msgs/msg/BatteryState"
DEPTH = 10
"""The most messages of a topic that may wait."""
LOOK = 3.0
"""Seconds after which an unseen node counts as absent. Two processes took up to 2.64 s to discover each other."""
RECEIVE_LIMIT = 300.0
"""Seconds for which Twists are reported, so that a receiver doesn't run forever after its parent was killed."""


def main() -> int:
    """Print the result of a command, as JSON."""
    say = own_output()
    command, *arguments = sys.argv[1:]
    if command == "look":
        say(look(arguments))
    elif command == "text":
        say(text(arguments[0]))
    else:
        twists(arguments[0], say)
    return 0


def look(topics: Sequence[str]) -> Graph:
    """List the listeners and publishers on these topics and on all other velocity topics, with the poses and battery
    levels that arrive there."""
    import rclpy

    with _node("improv_look") as node:
        heard = _Heard(node, topics)
        end = time.monotonic() + LOOK
        while time.monotonic() < end:
            heard.listen()
            rclpy.spin_once(node, timeout_sec=0.05)
        moving = [topic for topic, types in node.get_topic_names_and_types() if set(types) & set(VELOCITIES)]
        return {
            topic: {
                "listeners": _ends(node.get_subscriptions_info_by_topic(topic)),
                "publishers": _ends(node.get_publishers_info_by_topic(topic)),
                "age": heard.ages.get(topic),
                "gap": heard.gap(topic, end),
                "pose": heard.poses.get(topic),
                "battery": heard.batteries.get(topic),
            }
            for topic in sorted({*topics, *moving})
        }


def twists(topic: str, say: Callable[[Sequence[float]], None]) -> None:
    """Report an empty list once subscribed, then each Twist: x, y, z, and yaw."""
    from geometry_msgs.msg import Twist

    def hear(message: Any) -> None:
        say([message.linear.x, message.linear.y, message.linear.z, message.angular.z])

    with _node("improv_receive") as node:
        node.create_subscription(Twist, topic, hear, 10)
        say([])
        _spin(node, [], RECEIVE_LIMIT)


def text(topic: str) -> str | None:
    """The text on a topic that keeps its latest message for later subscribers, as /robot_description does."""
    from rclpy.qos import DurabilityPolicy, QoSProfile
    from std_msgs.msg import String

    heard: list[Any] = []
    with _node("improv_text") as node:
        keeps = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        node.create_subscription(String, topic, heard.append, keeps)
        _spin(node, heard, LOOK)
    return str(heard[0].data) if heard else None


def _spin(node: Any, heard: Sequence[Any], seconds: float) -> None:
    """Spin until a message has arrived, or for this many seconds."""
    import rclpy

    end = time.monotonic() + seconds
    while not heard and time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)


@contextmanager
def _node(name: str) -> Iterator[Any]:
    import rclpy

    rclpy.init()
    node = rclpy.create_node(name)
    try:
        yield node
    finally:
        # A node that exits without destroying itself stays in the graph for its lease, about twenty seconds.
        node.destroy_node()
        rclpy.try_shutdown()


class _Heard:
    """Poses and battery levels that arrive on topics. The newest stamp gives a topic's age."""

    def __init__(self, node: Any, topics: Sequence[str]) -> None:
        self._node = node
        self._unheard = set(topics)
        self._times: dict[str, list[float]] = {}
        self.ages: dict[str, float] = {}
        self.poses: dict[str, PoseJson] = {}
        self.batteries: dict[str, float] = {}

    def listen(self) -> None:
        """Subscribe to topics on which a publisher of poses or batteries has appeared."""
        for topic in list(self._unheard):
            infos = self._node.get_publishers_info_by_topic(topic)
            if info := next((info for info in infos if info.topic_type in (*POSES, TF, BATTERY)), None):
                hear = {BATTERY: self._hear_battery, TF: self._hear_transforms}.get(info.topic_type, self._hear_pose)
                package, _, kind = info.topic_type.split("/")
                found = getattr(import_module(f"{package}.msg"), kind)
                for qos in qualities_for(DEPTH, any(map(is_latched, infos))):
                    self._node.create_subscription(found, topic, partial(hear, topic), qos)
                self._unheard.discard(topic)

    def gap(self, topic: str, end: float) -> float:
        """The longest time without a pose, in seconds, until the end of the look."""
        times = self._times.get(topic, [])
        return max((later - earlier for earlier, later in pairwise([*times, end])), default=0.0) if times else 0.0

    def _hear_transforms(self, topic: str, message: Any) -> None:
        for transform in message.transforms:
            self._note_age(topic, transform.header.stamp)
        self._times.setdefault(topic, []).append(time.monotonic())

    def _note_age(self, topic: str, stamp: Any) -> None:
        age = time.time() - stamp.sec - stamp.nanosec / 1e9
        # AMCL stamps its transforms ahead, so that they count until the next.
        self.ages[topic] = min(max(age, 0.0) if topic.endswith("tf") else age, self.ages.get(topic, age))

    def _hear_pose(self, topic: str, message: Any) -> None:
        self._note_age(topic, message.header.stamp)
        if type(message).__name__ != "PoseWithCovarianceStamped":  # which comes only after a movement
            self._times.setdefault(topic, []).append(time.monotonic())
        pose = message.pose if type(message).__name__ == "PoseStamped" else message.pose.pose
        place, turned = pose.position, pose.orientation
        heading = 2 * math.atan2(turned.z, turned.w)
        self.poses[topic] = {"x": place.x, "y": place.y, "z": place.z, "heading": heading}

    def _hear_battery(self, topic: str, message: Any) -> None:
        if (share := battery(message)) is not None:
            self.batteries[topic] = share


def _ends(infos: Sequence[Any]) -> list[Endpoint]:
    ends: list[Endpoint] = [
        {
            "node": _name(info),
            "type": info.topic_type,
            "reliable": info.qos_profile.reliability.name == "RELIABLE",
            "latched": info.qos_profile.durability.name == "TRANSIENT_LOCAL",
        }
        for info in infos
    ]
    return sorted(ends, key=lambda end: (end["node"], end["type"]))


def _name(info: Any) -> str:
    unknown = info.node_name == "_NODE_NAME_UNKNOWN_"
    return UNNAMED if unknown else f"{info.node_namespace.rstrip('/')}/{info.node_name}"
