"""Emergency stops and deadman buttons that people press in ROS 2 while robots move (messages imported lazily)."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Collection
from typing import Any

from improv_core.outputs.ros.nodes import is_published, subscribe, unpublished
from improv_core.outputs.ros.topic import Now
from improv_core.protocol.limits import DEADMAN_LIMIT
from improv_core.protocol.output import Edge, StopButton
from improv_core.safety.interlocks import StopTopic
from improv_core.score.score import Safety

LOOK = 0.05
"""Seconds between two checks for silence and for new publishers."""
FOUND = 0.5
"""Seconds from finding a publisher of the emergency stop until its earlier messages have arrived."""
SURE = 0.1
"""Seconds without a released deadman button until a held one counts, because two gamepads may publish on one topic."""
DEPTH = 1_000
"""The most messages of an emergency stop that may wait. All publishers of a topic share the queue, and the others must
not push out a press. Ten publishers at 20 Hz fill it in five seconds."""
FIND_LIMIT = 5.0
"""Seconds that beat 0 waits for a publisher of the emergency stop, which may already be pressed."""


class Buttons:
    """Subscribes to the buttons that a score names, and passes on changes as edges, on the executor's thread."""

    def __init__(self, node: Any, hear: Callable[[Edge], None], now: Now) -> None:
        self._node = node
        self._hear = hear
        self._now = now
        self._safety = Safety()
        self._held: bool | None = None  # the latest state of the deadman button, if known
        self._stops: dict[str, StopTopic] = {}  # the topics with a subscription
        self._changing = threading.Lock()  # guards `_stops`
        self._heard = -math.inf  # when the latest message of the deadman button arrived
        self._released = -math.inf  # when it was last not held
        self._asked = -math.inf  # when the subscription to the emergency stop began
        self._found = math.inf  # since when it has a publisher
        self._destroy: dict[str, Callable[[], None]] = {}

    def take(self, safety: Safety) -> None:
        """Subscribe to the buttons that a score names, and keep the emergency stops that are on."""
        old, self._safety = self._safety, safety
        with self._changing:
            left = [topic for topic, stop in self._stops.items() if topic != safety.stop and not stop.on]
            for topic in left:
                del self._stops[topic]
        for topic in left:
            self._destroy.pop(topic)()
        if old.stop != safety.stop and safety.stop:
            self._asked, self._found = self._now(), math.inf
            self._listen_to(safety.stop, StopTopic())
        if old.deadman != safety.deadman:
            if old.deadman:
                self._destroy.pop(str(old.deadman))()
                self._hold(str(old.deadman), None)
            if safety.deadman:
                self._destroy[str(safety.deadman)] = self._subscribe_deadman(
                    str(safety.deadman), safety.deadman.topic, safety.deadman.button
                )

    def guard(self, topics: Collection[str]) -> None:
        for topic in topics:
            self._listen_to(topic, StopTopic(on=True, latest=True))

    def under_way(self) -> bool:
        """Return whether it is still unknown if the emergency stop is on. Call it repeatedly before beat 0."""
        if not self._safety.stop:
            return False
        now = self._now()
        if not is_published(self._node, self._safety.stop):
            self._found = math.inf
            return now < self._asked + FIND_LIMIT
        self._found = min(self._found, now)
        return now < self._found + FOUND

    def warnings(self) -> dict[str, str]:
        """A line for each topic that has no publisher, or only publishers of another type."""
        wanted = [(self._safety.stop, "std_msgs/msg/Bool", "the emergency stop there stops nothing")]
        if self._safety.deadman:
            wanted.append((self._safety.deadman.topic, "sensor_msgs/msg/Joy", "robots wait for it"))
        found = {}
        for topic, kind, so in wanted:
            if topic and (why := unpublished(self._node, topic, kind)):
                found[topic] = f"{why}, so {so}"
        return found

    def _hold(self, what: str, value: bool | None) -> None:
        if self._held != value:
            self._held = value
            self._hear(Edge(what, value, self._now()))

    def _change(self, topic: str, change: Callable[[StopTopic], StopTopic]) -> None:
        with self._changing:
            if before := self._stops.get(topic):  # otherwise, the subscription is gone
                after = self._stops[topic] = change(before)
                if after.on != before.on:
                    self._hear(Edge(StopButton(topic), after.on, self._now()))

    def _listen_to(self, topic: str, stop: StopTopic) -> None:
        if topic not in self._stops:
            self._stops[topic] = stop
            self._destroy[topic] = self._subscribe_stop(topic)

    def _subscribe_stop(self, topic: str) -> Callable[[], None]:
        from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
        from std_msgs.msg import Bool

        def hear(reliability: Any, durability: Any) -> Any:
            def take(message: Any) -> None:
                # Take all waiting messages at once: the executor calls this only once for each message.
                values = [message.data]
                for subscription in made:  # none yet if a message arrives at once
                    while waiting := subscription.handle.take_message(Bool, False):
                        values.append(waiting[0].data)
                self._change(topic, lambda stop: stop.heard(values, self._now()))

            made: list[Any] = []
            qos = QoSProfile(depth=DEPTH, reliability=reliability, durability=durability)
            made.append(subscribe(self._node, Bool, topic, take, qos))
            return made[0]

        # This one receives from every publisher. A reliable publisher gets a second subscription, so that nothing is
        # lost, and with its own durability, so that its earlier messages arrive too. Asking for more than it offers
        # would be an error there.
        subscriptions = {None: hear(ReliabilityPolicy.BEST_EFFORT, DurabilityPolicy.VOLATILE)}

        def look() -> None:
            for publisher in self._node.get_publishers_info_by_topic(topic):
                offered = publisher.qos_profile
                if offered.reliability == ReliabilityPolicy.RELIABLE and offered.durability not in subscriptions:
                    subscriptions[offered.durability] = hear(offered.reliability, offered.durability)
            self._change(topic, lambda stop: stop.looked(self._now()))

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
            held = bool(message.buttons[button]) if button < len(message.buttons) else None
            if not held:
                self._released = self._heard
            if not held or self._heard >= self._released + SURE:
                self._hold(what, held)

        def look() -> None:
            if self._now() >= self._heard + DEADMAN_LIMIT:
                self._hold(what, None)

        # Best effort matches all publishers, and a lost message isn't worth waiting for.
        qos = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        subscription = subscribe(self._node, Joy, topic, take, qos)
        stop_looking = self._every(LOOK, look)

        def destroy() -> None:
            stop_looking()
            self._node.destroy_subscription(subscription)

        return destroy

    def _every(self, seconds: float, look: Callable[[], None]) -> Callable[[], None]:
        """Call something regularly on the executor's thread; returns a function that ends it."""
        from rclpy.clock import Clock, ClockType

        # The node's clock can't time this: the one of a simulation may stand still.
        timer = self._node.create_timer(seconds, look, clock=Clock(clock_type=ClockType.STEADY_TIME))
        return lambda: self._node.destroy_timer(timer)
