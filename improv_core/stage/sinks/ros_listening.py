"""What people press in ROS 2 while robots move: an emergency stop, a deadman button (messages imported lazily)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from improv_core.score.score import Safety
from improv_core.stage.protocol import DEADMAN_LIMIT
from improv_core.stage.sinks import Edge
from improv_core.stage.sinks.ros_nodes import subscribe
from improv_core.stage.sinks.ros_topic import Now

LOOK = 0.05
"""Seconds between two looks for silence, and for new publishers."""
FOUND = 0.5
"""Seconds from finding a publisher of the emergency stop until what it has said before has arrived."""
FIND_LIMIT = 5.0
"""Seconds that beat 0 waits for a publisher of the emergency stop, which may be on already."""


class Listening:
    """Subscribes to what a score names, and passes on each change as an edge, on the thread of the node's executor."""

    def __init__(self, node: Any, hear: Callable[[Edge], None], now: Now) -> None:
        self._node = node
        self._hear = hear
        self._now = now
        self._safety = Safety()
        self._values: dict[str, bool | None] = {}
        self._heard = -math.inf  # when the deadman button was last heard of
        self._asked = -math.inf  # when the emergency stop was first listened for
        self._found = math.inf  # since when somebody publishes it
        self._destroy: dict[str, Callable[[], None]] = {}

    def take(self, safety: Safety) -> None:
        """Listen to what a score names, and to nothing else."""
        old, self._safety = self._safety, safety
        if old.stop != safety.stop:
            self._drop(old.stop)
            if safety.stop:
                self._asked, self._found = self._now(), math.inf
                self._destroy[safety.stop] = self._subscribe_stop(safety.stop)
        if old.deadman != safety.deadman:
            self._drop(str(old.deadman) if old.deadman else None)
            if safety.deadman:
                self._destroy[str(safety.deadman)] = self._subscribe_deadman(
                    str(safety.deadman), safety.deadman.topic, safety.deadman.button
                )

    def under_way(self) -> bool:
        """Whether it is still unknown if the emergency stop is on. Call it repeatedly before beat 0."""
        if not self._safety.stop:
            return False
        now = self._now()
        if not self._count_publishers(self._safety.stop):
            self._found = math.inf
            return now < self._asked + FIND_LIMIT
        self._found = min(self._found, now)
        return now < self._found + FOUND

    def warnings(self) -> dict[str, str]:
        """A line for each topic that nobody publishes, or of another type."""
        wanted = [(self._safety.stop, "std_msgs/msg/Bool", "the emergency stop there stops nothing")]
        if self._safety.deadman:
            wanted.append((self._safety.deadman.topic, "sensor_msgs/msg/Joy", "robots wait for it"))
        found = {}
        for topic, kind, so in wanted:
            if topic and not self._count_publishers(topic):
                found[topic] = f"nobody publishes on {topic}, so {so}"
            elif topic:
                kinds = {info.topic_type for info in self._node.get_publishers_info_by_topic(topic)}
                if kind not in kinds:
                    found[topic] = f"{topic} carries {', '.join(sorted(kinds))}, not {kind}, so {so}"
        return found

    def _count_publishers(self, topic: str) -> int:
        return int(self._node.count_publishers(self._node.resolve_topic_name(topic)))

    def _drop(self, what: str | None) -> None:
        if what:
            self._destroy.pop(what)()
            self._turn(what, None)

    def _turn(self, what: str, value: bool | None) -> None:
        if self._values.get(what) != value:
            self._values[what] = value
            self._hear(Edge(what, value, self._now()))

    def _subscribe_stop(self, topic: str) -> Callable[[], None]:
        from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
        from std_msgs.msg import Bool

        def hear(reliability: Any, durability: Any) -> Any:
            qos = QoSProfile(depth=1, reliability=reliability, durability=durability)
            return subscribe(self._node, Bool, topic, lambda message: self._turn(topic, message.data), qos)

        # This one hears every publisher. A reliable one is heard a second time, so that nothing is lost, and if it
        # offers what it said before, that too; asking for more than is offered would be reported as an error there.
        subscriptions = {None: hear(ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.VOLATILE)}

        def look() -> None:
            for publisher in self._node.get_publishers_info_by_topic(topic):
                offered = publisher.qos_profile
                if offered.reliability == ReliabilityPolicy.RELIABLE and offered.durability not in subscriptions:
                    subscriptions[offered.durability] = hear(offered.reliability, offered.durability)

        stop_looking = self._every(LOOK, look)

        def destroy() -> None:
            stop_looking()
            for subscription in subscriptions.values():
                self._node.destroy_subscription(subscription)

        return destroy

    def _subscribe_deadman(self, what: str, topic: str, button: int) -> Callable[[], None]:
        from rclpy.qos import QoSProfile, ReliabilityPolicy
        from sensor_msgs.msg import Joy

        def take(message: Any) -> None:
            self._heard = self._now()
            self._turn(what, bool(message.buttons[button]) if button < len(message.buttons) else None)

        def look() -> None:
            if self._now() >= self._heard + DEADMAN_LIMIT:
                self._turn(what, None)

        # All publishers match best effort, and what is lost is not worth waiting for.
        qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        subscription = subscribe(self._node, Joy, topic, take, qos)
        stop_looking = self._every(LOOK, look)

        def destroy() -> None:
            stop_looking()
            self._node.destroy_subscription(subscription)

        return destroy

    def _every(self, seconds: float, look: Callable[[], None]) -> Callable[[], None]:
        """Call something again and again on the executor's thread; returns what ends that."""
        from rclpy.clock import Clock, ClockType

        # Not by the node's clock: a simulation's may stand still.
        timer = self._node.create_timer(seconds, look, clock=Clock(clock_type=ClockType.STEADY_TIME))
        return lambda: self._node.destroy_timer(timer)
