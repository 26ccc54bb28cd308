"""Topics of robots whose messages are taken at regular times (rclpy and messages imported lazily).

Only messages that are used are taken. DDS discards the others itself: it keeps the latest of each topic.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from importlib import import_module
from typing import Any, NamedTuple

from improv_core.outputs.ros.nodes import is_latched, qualities_for, subscribe

TF = "tf2_msgs/TFMessage"
"""The message with transforms between frames."""
STATIC = "_static"
"""Ends the name of the topic for transforms that never change. It is also a fact about their messages."""
Unread = Callable[[str, str], None]
"""Gets a topic to which it is impossible to subscribe, and a line with the reason."""


class Polled(NamedTuple):
    """The new messages on a topic of these robots, each with facts about its arrival."""

    robots: Sequence[str]
    topic: str
    kind: str
    messages: Sequence[tuple[Any, Mapping[str, Any]]]


class PolledTopics:
    """Subscribes to the topics of robots, on a node without an executor, so that messages that nobody takes cost
    nothing.

    If several `kinds` of messages are possible, the publishers on a topic decide, as soon as there are some. The
    latest messages of each kind are kept, up to its number, serialized if `raw`. `period` is the fewest seconds between
    reads.
    """

    def __init__(
        self,
        node: Callable[[], Any],
        unread: Unread,
        kinds: Mapping[str, int],
        *,
        raw: bool = True,
        period: float = 0.0,
    ) -> None:
        self._node = node
        self._unread = unread
        self._kinds = kinds
        self._raw = raw
        self._period = period
        self._robots: dict[str, list[str]] = {}  # by topic
        # By topic, the type, and the subscriptions with facts about all of their messages.
        self._made: dict[str, tuple[str, list[tuple[Any, Mapping[str, Any]]]]] = {}
        self._failed: dict[str, set[str]] = {}  # the types on topics that can't be read
        self._due = 0.0

    def keep(self, topics: Mapping[str, str]) -> None:
        """Subscribe to the topics of these robots, and to no others."""
        self._robots, self._failed = {}, {}
        for robot, topic in topics.items():
            self._robots.setdefault(topic, []).append(robot)
        for topic in self._made.keys() - self._robots.keys():
            for subscription, _ in self._made.pop(topic)[1]:
                self._node().destroy_subscription(subscription)

    def take(self) -> Iterator[Polled]:
        """Yield the messages that have come."""
        now = time.monotonic()
        if not self._robots or now < self._due:
            return
        self._due = now + self._period
        for topic in self._robots.keys() - self._made.keys():
            self._look(topic)
        for topic, (kind, subscriptions) in self._made.items():
            if messages := [message for each in subscriptions for message in self._waiting(*each, self._kinds[kind])]:
                yield Polled(self._robots[topic], topic, kind, messages)

    def _waiting(
        self, subscription: Any, facts: Mapping[str, Any], most: int
    ) -> Iterator[tuple[Any, Mapping[str, Any]]]:
        """Yield the messages that wait, the latest ones at most."""
        with subscription.handle:
            for _ in range(most):
                if not (taken := subscription.handle.take_message(subscription.msg_type, self._raw)):
                    return
                message, about = taken
                yield message, {**about, **facts} if facts else about

    def _look(self, topic: str) -> None:
        """Subscribe to a topic if the type of its messages is known by now."""
        kinds, latched = {*self._kinds}, False
        if len(kinds) > 1:
            infos = self._node().get_publishers_info_by_topic(topic)
            kinds = {info.topic_type.replace("/msg/", "/") for info in infos}
            latched = any(map(is_latched, infos))
        if not kinds or kinds == self._failed.get(topic):
            return
        self._failed[topic] = kinds
        if kind := next((kind for kind in self._kinds if kind in kinds), None):
            depth, made = self._kinds[kind], list[tuple[Any, Mapping[str, Any]]]()
            # Transforms that never change have a topic of their own.
            fixed = [(f"{topic}{STATIC}", qos) for qos in qualities_for(depth, True)] if kind == TF else []
            for name, qos in [*fixed, *((topic, qos) for qos in qualities_for(depth, latched))]:
                subscription = try_subscribe(self._node(), kind, name, _nothing, qos, self._unread)
                made.append((subscription, {} if name == topic else {STATIC: True}))
            if all(subscription for subscription, _ in made):
                self._made[topic] = kind, made
        else:
            self._unread(topic, f"{topic} carries {', '.join(sorted(kinds))}, not {', '.join(self._kinds)}")


def _nothing(message: Any) -> None:
    """Take no message: nothing spins the node."""


def try_subscribe(node: Any, kind: str, topic: str, take: Callable[[Any], None], qos: Any, unread: Unread) -> Any:
    """Return a subscription to messages of a type; None if that is impossible."""
    package, _, name = kind.partition("/")
    try:
        return subscribe(node, getattr(import_module(f"{package}.msg"), name), topic, take, qos)
    except ImportError:
        unread(topic, f"{sys.executable} can't import {package}, so {topic} can't be read: install {package}")
    except Exception as error:  # rclpy raises many exceptions, such as for a topic on which we use another type
        unread(topic, f"{topic} can't be read as {kind}: {error}")
    return None
