"""Topics of robots whose messages are taken at regular times (rclpy and messages imported lazily).

Only messages that are used are taken. DDS discards the others itself: it keeps the latest of each topic.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from importlib import import_module
from typing import Any, NamedTuple

from improv_core.outputs.ros.nodes import is_latched, qualities_for, subscribe

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

    If several `kinds` of messages are possible, the publishers on a topic decide, as soon as there are some. Keeps the
    latest `depth` messages, serialized if `raw`. `period` is the fewest seconds between two looks.
    """

    def __init__(
        self,
        node: Callable[[], Any],
        unread: Unread,
        kinds: Collection[str],
        depth: int,
        *,
        raw: bool = True,
        period: float = 0.0,
    ) -> None:
        self._node = node
        self._unread = unread
        self._kinds = kinds
        self._depth = depth
        self._raw = raw
        self._period = period
        self._robots: dict[str, list[str]] = {}  # by topic
        self._made: dict[str, tuple[str, list[Any]]] = {}  # the type and the subscriptions, by topic
        self._failed: dict[str, set[str]] = {}  # the types on topics that can't be read
        self._due = 0.0

    def keep(self, topics: Mapping[str, str]) -> None:
        """Subscribe to the topics of these robots, and to no others."""
        self._robots, self._failed = {}, {}
        for robot, topic in topics.items():
            self._robots.setdefault(topic, []).append(robot)
        for topic in self._made.keys() - self._robots.keys():
            for subscription in self._made.pop(topic)[1]:
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
            if messages := [message for each in subscriptions for message in self._waiting(each)]:
                yield Polled(self._robots[topic], topic, kind, messages)

    def _waiting(self, subscription: Any) -> Iterator[tuple[Any, Mapping[str, Any]]]:
        """Yield the messages that wait, the latest `depth` at most."""
        with subscription.handle:
            for _ in range(self._depth):
                if not (taken := subscription.handle.take_message(subscription.msg_type, self._raw)):
                    return
                yield taken

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
            take = lambda message: None  # noqa: E731, nothing spins the node
            qualities = qualities_for(self._depth, latched)
            made = [try_subscribe(self._node(), kind, topic, take, qos, self._unread) for qos in qualities]
            if all(made):
                self._made[topic] = kind, made
        else:
            self._unread(topic, f"{topic} carries {', '.join(sorted(kinds))}, not {', '.join(self._kinds)}")


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
