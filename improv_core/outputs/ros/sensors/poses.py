"""The poses of robots from ROS topics (rclpy and messages imported lazily).

Only messages that are used are taken. DDS discards the others itself: it keeps the last message of each topic.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from improv_core.outputs.cdr import SECOND, frame_in, pose_in, stamp_in
from improv_core.outputs.ros.nodes import subscribe
from improv_core.protocol.output import RawPose

TEXTS = {
    "nav_msgs/Odometry": 2,
    "geometry_msgs/PoseStamped": 1,
    "geometry_msgs/PoseWithCovarianceStamped": 1,
}
"""The messages with a pose after a stamp, and the number of texts (names of frames) in between."""
LONGEST_WAIT = SECOND
"""The longest that a message may have waited, in nanoseconds. Beyond it, the clocks don't agree."""


class RosPoses:
    """Subscribes to the topics of robots' poses as soon as they have publishers.

    No executor uses `node`, so messages that nobody takes cost nothing. `unread` gets each topic to which it can't
    subscribe, and a line with the reason.
    """

    def __init__(self, node: Callable[[], Any], unread: Callable[[str, str], None]) -> None:
        self._make_node = node
        self._node: Any = None
        self._unread = unread
        self._robots: dict[str, list[str]] = {}  # by topic
        self._made: dict[str, tuple[str, Any]] = {}  # the type and the subscription, by topic
        self._failed: dict[str, str] = {}

    def keep(self, topics: Mapping[str, str]) -> None:
        """Subscribe to the topics of these robots, and to no others."""
        self._robots, self._failed = {}, {}
        for robot, topic in topics.items():
            self._robots.setdefault(topic, []).append(robot)
        for topic in self._made.keys() - self._robots.keys():
            self._node.destroy_subscription(self._made.pop(topic)[1])

    def take(self) -> list[RawPose]:
        """The latest pose of each robot, if it is new."""
        if not self._robots:
            return []
        self._node = self._node or self._make_node()
        for topic in self._robots.keys() - self._made.keys():
            self._look(topic)
        found = []
        for topic, (kind, subscription) in self._made.items():
            with subscription.handle:
                taken = subscription.handle.take_message(subscription.msg_type, True)
            if taken and (pose := pose_in(taken[0], TEXTS[kind])):
                at = _arrived(taken[1])
                frame, stamp = frame_in(taken[0]), _stamped(stamp_in(taken[0]))
                found += [RawPose(robot, kind, pose, at, frame, stamp, topic) for robot in self._robots[topic]]
        return found

    def close(self) -> None:
        """Destroy the node."""
        if self._node:
            self._node.destroy_node()

    def _look(self, topic: str) -> None:
        """Subscribe to a topic if the type of its poses is known by now."""
        kinds = {info.topic_type.replace("/msg/", "/") for info in self._node.get_publishers_info_by_topic(topic)}
        if kind := next((kind for kind in TEXTS if kind in kinds), None):
            try:
                self._made[topic] = kind, self._subscribe(topic, kind)
                return
            except ImportError:
                package, _, _ = kind.partition("/")
                line = f"{sys.executable} can't import {package}, so {topic} can't be read: install {package}"
            except Exception as error:  # rclpy raises many exceptions, such as for a topic on which we use another type
                line = f"{topic} can't be read as {kind}: {error}"
        elif kinds:
            line = f"{topic} carries {', '.join(sorted(kinds))}, not {', '.join(TEXTS)}"
        else:
            return
        if self._failed.get(topic) != line:
            self._failed[topic] = line
            self._unread(topic, line)

    def _subscribe(self, topic: str, kind: str) -> Any:
        from rclpy.qos import QoSProfile, ReliabilityPolicy

        package, _, name = kind.partition("/")
        qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        found = getattr(import_module(f"{package}.msg"), name)
        return subscribe(self._node, found, topic, lambda message: None, qos, raw=True)


def _arrived(about: Mapping[str, Any]) -> float:
    """The time of arrival of a message, on the monotonic clock. Its stamp may come from another machine's clock."""
    waited = time.time_ns() - (about.get("received_timestamp") or 0)
    return time.monotonic() - (waited / SECOND if 0 <= waited <= LONGEST_WAIT else 0.0)


def _stamped(stamp: int) -> float | None:
    """A stamp in nanoseconds, on the monotonic clock, as if the sender's clock were ours. None if it is 0."""
    return time.monotonic() + (stamp - time.time_ns()) / SECOND if stamp else None
