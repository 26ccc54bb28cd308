"""Inspection of the ROS 2 graph. It never publishes anything (rclpy, imported lazily). Standard library only.

ROS's interpreter runs it as `python …/improv_core/stage graph look TOPIC...`, `graph twists TOPIC`, or
`graph text TOPIC`.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import chain, pairwise
from typing import Any, TypedDict

from improv_core.outputs.cdr import POSE_TEXTS, SECOND, pose_in, stamp_in, transforms_in
from improv_core.outputs.ros.nodes import Nodes
from improv_core.outputs.ros.sensors.polled import STATIC, TF, PolledTopics
from improv_core.outputs.ros.sensors.poses import KINDS
from improv_core.outputs.ros.sensors.readings import battery
from improv_core.outputs.ros.sensors.subscriptions import BATTERY
from improv_core.protocol.fields import PoseJson, to_pose_json
from improv_core.protocol.json_lines import own_output
from improv_core.safety.odometry import AFTER_MOVING

VELOCITIES = ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped")
"""The message types that move robots."""
LOOK = 3.0
"""Seconds after which an unseen node counts as absent. Two processes took up to 2.64 s to discover each other."""
REST = 0.02
"""Seconds between checks for poses."""
RECEIVE_LIMIT = 300.0
"""Seconds for which Twists are reported, so that a receiver doesn't run forever after its parent was killed."""
UNNAMED = "an unnamed node"
"""The name for a node that the graph shows before the node itself has announced its name."""


class Endpoint(TypedDict):
    """A publisher or a subscription: its node, the type of its messages, and its quality of service."""

    node: str
    type: str
    reliable: bool
    latched: bool
    """True if it is transient local."""


class Endpoints(TypedDict):
    """All endpoints of a topic."""

    listeners: list[Endpoint]
    publishers: list[Endpoint]
    age: float | None
    """The age of the newest pose when it came, in seconds by its stamp and our clock; None if none came."""
    gap: float
    """Seconds for which no pose came though some had come; 0 from sources that send one only after a movement."""
    pose: PoseJson | None
    """The latest pose."""
    battery: float | None
    """The charge of a battery, from 0 to 1."""


Graph = dict[str, Endpoints]
"""The endpoints by topic."""


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
    """List who listens and publishes on these and all other velocity topics, and the poses and batteries there."""
    with _node("improv_look") as node:
        heard = _Heard(node, topics)
        end = time.monotonic() + LOOK
        while time.monotonic() < end:
            heard.listen()
            time.sleep(REST)
        moving = [topic for topic, types in node.get_topic_names_and_types() if set(types) & set(VELOCITIES)]
        return {
            topic: {
                "listeners": _ends(node.get_subscriptions_info_by_topic(topic)),
                "publishers": _ends(node.get_publishers_info_by_topic(topic)),
                "age": heard.age(topic),
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
    nodes = Nodes(name)
    try:
        yield nodes.first
    finally:
        nodes.close()


class _Heard:
    """Poses and battery levels that arrive on topics. The newest stamp gives a topic's age."""

    def __init__(self, node: Any, topics: Sequence[str]) -> None:
        self._topics = PolledTopics(lambda: node, lambda topic, why: None, {**KINDS, BATTERY: 1})
        self._topics.keep({topic: topic for topic in topics})
        self._times: dict[str, list[float]] = {}
        self._ages: dict[str, list[float]] = {}
        self.poses: dict[str, PoseJson] = {}
        self.batteries: dict[str, float] = {}

    def listen(self) -> None:
        """Take the messages that have come, also on topics on which a publisher has just appeared."""
        for _, topic, kind, messages in self._topics.take():
            latest, ages = messages[-1][0], self._ages.setdefault(topic, [])
            if kind == BATTERY:
                self._take_battery(topic, latest)
                continue
            if kind != AFTER_MOVING:
                self._times.setdefault(topic, []).append(time.monotonic())
            if kind == TF:
                moving = chain.from_iterable(transforms_in(each) for each, about in messages if STATIC not in about)
                # AMCL stamps its transforms ahead, so that they count until the next.
                ages += [max(_age(each.stamp), 0.0) for each in moving]
            elif pose := pose_in(latest, POSE_TEXTS[kind]):
                ages.append(_age(stamp_in(latest)))
                self.poses[topic] = to_pose_json(pose)

    def age(self, topic: str) -> float | None:
        return min(self._ages.get(topic, ()), default=None)

    def gap(self, topic: str, end: float) -> float:
        """The longest time without a pose, in seconds, until the end of the check."""
        times = self._times.get(topic, [])
        return max((later - earlier for earlier, later in pairwise([*times, end])), default=0.0) if times else 0.0

    def _take_battery(self, topic: str, message: bytes) -> None:
        from rclpy.serialization import deserialize_message
        from sensor_msgs.msg import BatteryState

        if (share := battery(deserialize_message(message, BatteryState))) is not None:
            self.batteries[topic] = share


def _age(stamp: int) -> float:
    return time.time() - stamp / SECOND


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
