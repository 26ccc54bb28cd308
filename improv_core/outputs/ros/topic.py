"""A ROS 2 topic of a robot: the types that its listeners expect, and its publishers (nodes are passed in)."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import replace
from functools import partial
from importlib import import_module
from typing import Any

from improv_core.outputs.cdr import stamped
from improv_core.outputs.ros.subscriber_check import (
    Hearing,
    answered,
    counted,
    is_overdue,
    may_answer,
    replaced,
    zeros_to_send,
)
from improv_core.safety.pending_zeros import LINGER

TWISTS = {"Twist": "geometry_msgs/msg/Twist", "TwistStamped": "geometry_msgs/msg/TwistStamped"}
"""The message types that Improv can send to a base: their names in profiles and in ROS."""
TYPES = {
    **TWISTS,
    "JointTrajectory": "trajectory_msgs/msg/JointTrajectory",
    "Float64MultiArray": "std_msgs/msg/Float64MultiArray",
}
"""All message types that Improv can send, with those for controllers of joints."""
FIND_LIMIT = 10.0
"""Seconds that a listener and a publisher may take to find each other on a busy machine."""

Now = Callable[[], float]
"""The monotonic time, in seconds."""
Advertise = Callable[[Any, str, bool], tuple[Any, Callable[[], None]]]
"""Creates a publisher of a type on a topic, on the second node or not. Returns the publisher and a function that
destroys it."""


def message_class(kind: str) -> Any:
    """The class of a message type that Improv can send."""
    package, _, name = TYPES[kind].split("/")
    return getattr(import_module(f"{package}.msg"), name)


def has_confirmed(publisher: Any) -> bool:
    """Return whether a publisher's reliable listeners have confirmed everything; true also if nobody listens.

    They do so only when DDS asks: it took up to 3.1 s (https://github.com/ros2/rmw_fastrtps/issues/844).
    """
    from rclpy.duration import Duration

    return bool(publisher.wait_for_all_acked(Duration()))  # without waiting


def confirms(node: Any, topic: str, kinds: Collection[str]) -> bool:
    """Return whether all listeners of these types confirm messages: they and their publishers are reliable."""
    ends = [*node.get_subscriptions_info_by_topic(topic), *node.get_publishers_info_by_topic(topic)]
    types = {TYPES[kind] for kind in kinds}
    return all(end.qos_profile.reliability.name == "RELIABLE" for end in ends if end.topic_type in types)


class RosTopic:
    """A topic and its publishers: of the fixed type, or with "auto" of each type that a listener expects.

    `node` sees the graph. `advertise` creates a publisher, on the second node if asked to: one node can't publish two
    types on one topic. A score that takes over can't wait, so with `at_once`, listeners that already match count at
    once.
    """

    def __init__(self, name: str, message: str, node: Any, advertise: Advertise, now: Now, at_once: bool) -> None:
        self.name = name
        self.seen_as: str = node.resolve_topic_name(name)
        """Its name in the graph, which ROS's arguments may remap."""
        self._node = node
        self._advertise = advertise
        self._now = now
        self._publishers: dict[str, _Publisher] = {}
        self._leaving: dict[str, tuple[_Publisher, float]] = {}  # and since when they have sent nothing
        self._message = message
        self._finding = math.inf  # since when listeners of our types are unmatched
        self.was_heard = False
        """True if it has ever had a listener."""
        self._serve({message if message in TYPES else "Twist"}, Hearing(trusts=at_once))

    @property
    def is_stamped(self) -> bool:
        return "TwistStamped" in self._publishers

    def take(self, message: str) -> None:
        """Send `message` from now on: a type, or "auto"."""
        self._message = message
        if message in TYPES:
            self._serve({message}, Hearing())

    def unsettle(self) -> None:
        """Expect the listeners to change, as after a reset. They count again once they have confirmed."""
        for publisher in self._publishers.values():
            publisher.hearing = replaced(self._now())

    def distrust(self) -> None:
        """Have all listeners confirm before they count, because the score can wait for them."""
        for publisher in self._publishers.values():
            publisher.hearing = Hearing()

    def ask(self, message: bytes, clock: Any, frame: str) -> None:
        """Have listeners confirm this message, which must move nothing, unless they already have."""
        for publisher in self._publishers.values():
            publisher.ask(self._now(), message, clock, frame)

    def missing(self, moves: bool) -> str | None:
        """The reason why a command would not be received now, or None; "" while listeners and publishers still find
        each other.

        `moves` is true if the robot is moving. Listeners that expect another type get it from now on. Takes a few
        microseconds if all listeners match: the stage calls it for every topic while robots move.
        """
        self._destroy_left()
        counts = [publisher.count() for publisher in self._publishers.values()]
        self.was_heard = self.was_heard or any(counts)
        listeners = self._node.count_subscribers(self.seen_as)
        wanted: set[str] = set()
        if listeners and (listeners != sum(counts) or 0 in counts):
            # Listeners of another type never match, but the graph shows their type.
            wanted = {listener.topic_type for listener in self._node.get_subscriptions_info_by_topic(self.name)}
            kinds = {kind for kind, name in TWISTS.items() if name in wanted}
            if kinds and self._message not in TYPES:
                self._serve(kinds, Hearing())
        heard = [publisher.is_heard(moves, self._now(), self._confirms) for publisher in self._publishers.values()]
        if all(heard) or not listeners:
            self._finding = math.inf
            return None if all(heard) else f"nothing is listening on {self.seen_as}"
        if wanted.isdisjoint(TYPES[kind] for kind in self._publishers) and not any(counts):
            return self._unfit(", ".join(sorted(wanted)))
        if any(counts):
            if any(is_overdue(publisher.hearing, self._now()) for publisher in self._publishers.values()):
                return (
                    f"a listener on {self.seen_as} doesn't confirm that it hears anything: "
                    "check whether it hangs or started before its network was up"
                )
            return ""
        self._finding = min(self._finding, self._now())
        if self._now() < self._finding + FIND_LIMIT:
            return self._incompatible() or ""
        return self._incompatible() or f"the listener on {self.seen_as} can't be reached: check the network"

    def count_listeners(self) -> int:
        """The number of listeners that our publishers are matched with."""
        return sum(publisher.count() for publisher in self._publishers.values())

    def has_confirmed(self) -> bool:
        """Return whether all reliable listeners have confirmed everything. They do so only when DDS asks."""
        return all(publisher.has_confirmed() for publisher in self._publishers.values())

    def confirms(self) -> bool:
        """Return whether all listeners confirm messages: they and our publishers are reliable."""
        return self._confirms(self._publishers)

    def others(self, own: Collection[str], standby: bool) -> list[str]:
        """The other nodes that publish here, without our `own`. A `standby` has as many publishers as we have."""
        own_publishers = len(self._publishers) + len(self._leaving)
        if self._node.count_publishers(self.seen_as) == own_publishers * (1 + standby):
            return []
        infos = self._node.get_publishers_info_by_topic(self.name)
        return sorted({f"{info.node_namespace.rstrip('/')}/{info.node_name}" for info in infos} - set(own))

    def publish(self, message: bytes, clock: Any, frame: str) -> None:
        """Send a serialized message to all listeners. `clock` stamps a TwistStamped, in this frame."""
        for send in self.ready(message, clock, frame):
            send()

    def ready(self, message: bytes, clock: Any, frame: str) -> list[Callable[[], None]]:
        """Return functions that do what `publish` does, in as little time as possible."""
        return [publisher.ready(message, clock, frame) for publisher in self._publishers.values()]

    def _confirms(self, kinds: Collection[str]) -> bool:
        return confirms(self._node, self.name, kinds)

    def _incompatible(self) -> str | None:
        """The reason why all listeners are incompatible with our reliable, volatile publishers; None if they aren't."""
        ours = {TYPES[kind] for kind in self._publishers}
        listeners = self._node.get_subscriptions_info_by_topic(self.name)
        wanted = {each.qos_profile.durability.name for each in listeners if each.topic_type in ours}
        if wanted != {"TRANSIENT_LOCAL"}:
            return None
        return f"the listener on {self.seen_as} requires transient local, which Improv can't offer: make it volatile"

    def _unfit(self, wanted: str) -> str:
        found = f"the listener on {self.seen_as} expects {wanted}"
        if self._message in TWISTS:
            return f"{found}, but `message` in improv.toml is {self._message}: change it"
        if self._message in TYPES:
            return f"{found}, not {TYPES[self._message]}: change the controller's `interface` or `topic` in improv.toml"
        return f"{found}, but Improv can only send {' or '.join(TWISTS.values())}"

    def _serve(self, kinds: set[str], hearing: Hearing) -> None:
        for kind in self._publishers.keys() - kinds:
            self._leaving[kind] = self._publishers.pop(kind), self._now()
        for kind in kinds - self._publishers.keys():
            if kind in self._leaving:
                self._publishers[kind], _ = self._leaving.pop(kind)
                continue
            others = [*self._publishers.values(), *(leaving for leaving, _ in self._leaving.values())]
            second = any(not publisher.is_second for publisher in others)
            self._publishers[kind] = _Publisher(self._advertise, kind, self.name, second, hearing)

    def _destroy_left(self) -> None:
        """Destroy publishers that nobody needs anymore: `ros2 topic echo` refuses a topic with two types."""
        for kind, (publisher, since) in list(self._leaving.items()):
            if self._now() >= since + LINGER:
                del self._leaving[kind]
                publisher.destroy()


class _Publisher:
    """A publisher of one type and the state of its listeners."""

    def __init__(self, advertise: Advertise, kind: str, topic: str, second: bool, hearing: Hearing) -> None:
        self.hearing = hearing
        self.is_second = second
        self._kind = kind
        self._is_stamped = kind == "TwistStamped"
        self._publisher, self.destroy = advertise(message_class(kind), topic, second)
        self.count: Callable[[], int] = self._publisher.get_subscription_count

    def is_heard(self, moves: bool, now: float, confirms: Callable[[Collection[str]], bool]) -> bool:
        """Return whether its listeners receive it, after looking for new ones."""
        self.hearing = counted(self.hearing, self.count(), now)
        if may_answer(self.hearing, moves, now) and self.has_confirmed():
            self.hearing = answered(self.hearing, confirms((self._kind,)), now)
        return self.hearing.is_heard(moves)

    def ask(self, now: float, message: bytes, clock: Any, frame: str) -> None:
        for _ in range(zeros_to_send(self.hearing, now)):
            self.ready(message, clock, frame)()
            self.hearing = replace(self.hearing, asked=now)

    def has_confirmed(self) -> bool:
        return has_confirmed(self._publisher)

    def ready(self, message: bytes, clock: Any, frame: str) -> Callable[[], None]:
        if self._is_stamped:
            return lambda: self._publisher.publish(stamped(message, clock.now().nanoseconds, frame))
        return partial(self._publisher.publish, message)
