"""What one writes without us, run by ROS's interpreter: a plain script that publishes Twists.

`anew TOPIC` publishes at once, until somebody has listened for a while. `steady SECONDS TOPIC...` waits for listeners,
says when it begins (monotonic clock), and publishes to all topics 20 times a second, ready messages at absolute times:
nothing that Python does can be more punctual.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence

import rclpy
from geometry_msgs.msg import Twist

RATE = 20
LAST = 0.5
"""Seconds that a script started anew goes on once it sees a listener, which may see it a little later."""


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


def steady(seconds: float, topics: Sequence[str]) -> None:
    node = rclpy.create_node("plain_steady")
    publishers = [node.create_publisher(Twist, topic, 10) for topic in topics]
    while not all(publisher.get_subscription_count() for publisher in publishers):
        time.sleep(0.01)
    time.sleep(1)  # the listener's side follows
    message = Twist()
    message.linear.x = 1.0
    begin = time.monotonic() + 0.1
    print(begin, flush=True)
    for count in range(round(seconds * RATE)):
        time.sleep(max(begin + count / RATE - time.monotonic(), 0))
        for publisher in publishers:
            publisher.publish(message)
    time.sleep(0.5)


if __name__ == "__main__":
    rclpy.init()
    if sys.argv[1] == "anew":
        anew(sys.argv[2])
    else:
        steady(float(sys.argv[2]), sys.argv[3:])
    rclpy.try_shutdown()
