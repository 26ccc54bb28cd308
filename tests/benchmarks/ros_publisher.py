"""A plain script that publishes Twists without Improv, run by ROS's interpreter.

`anew TOPIC` publishes at once, until somebody has listened for a while. `loop SECONDS TOPIC...` waits for listeners,
prints the time at which it begins (monotonic clock), and publishes to all topics 20 times a second, ready messages at
absolute times, another velocity each second.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import rclpy
from geometry_msgs.msg import Twist

RATE = 20
LAST = 0.5
"""Seconds for which a script keeps publishing once it sees a listener, which may see it a little later."""


def anew(topic: str) -> None:
    publisher = rclpy.create_node("plain_anew").create_publisher(Twist, topic, 10)
    message = Twist()
    message.linear.x = 1.0
    matched = None
    while matched is None or time.monotonic() < matched + LAST:
        publisher.publish(message)
        if matched is None and publisher.get_subscription_count():
            matched = time.monotonic()
        time.sleep(0.002)


def loop(seconds: float, topics: Sequence[str]) -> None:
    _, publish = _prepare(topics)
    begin = _begin()
    for count in range(round(seconds * RATE)):
        time.sleep(max(begin + count / RATE - time.monotonic(), 0))
        publish(count)
    time.sleep(0.5)


def _prepare(topics: Sequence[str]) -> tuple[Any, Callable[[int], None]]:
    """Return a node, and a function that publishes the message of so many periods after the beginning to all topics."""
    node = rclpy.create_node("plain_steady")
    publishers = [node.create_publisher(Twist, topic, 10) for topic in topics]
    while not all(publisher.get_subscription_count() for publisher in publishers):
        time.sleep(0.01)
    time.sleep(1)  # the listener's side follows
    forward, left = Twist(), Twist()
    forward.linear.x = left.angular.z = 1.0

    def publish(count: int) -> None:
        for publisher in publishers:
            publisher.publish(left if count // RATE % 2 else forward)

    return node, publish


def _begin(after: float = 0.1) -> float:
    begin = time.monotonic() + after
    print(begin, flush=True)
    return begin


if __name__ == "__main__":
    rclpy.init()
    if sys.argv[1] == "anew":
        anew(sys.argv[2])
    else:
        loop(float(sys.argv[2]), sys.argv[3:])
    rclpy.try_shutdown()
