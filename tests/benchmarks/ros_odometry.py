"""Odometry of robots, run by ROS's interpreter: `ros_odometry.py publish|listen ROBOT...`, until its input ends.

Publishes on /ROBOT/odom, fifty times a second each, all at different times; or listens to it as a plain script does and
prints the share of a core that this takes.
"""

from __future__ import annotations

import sys
import threading
import time

import rclpy
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message

RATE = 50


def publish(robots: list[str], ended: threading.Event) -> None:
    node = rclpy.create_node("bases")
    publishers = [node.create_publisher(Odometry, f"/{robot}/odom", 10) for robot in robots]
    odometry = Odometry(child_frame_id="base_link")
    odometry.header.frame_id, odometry.pose.pose.orientation.w = "odom", 1.0
    message = serialize_message(odometry)
    print(flush=True)
    due = time.monotonic()
    while not ended.is_set():
        for publisher in publishers:
            due += 1 / RATE / len(robots)
            time.sleep(max(due - time.monotonic(), 0))
            publisher.publish(message)


def listen(robots: list[str], ended: threading.Event) -> None:
    node = rclpy.create_node("plain")
    heard: list[float] = []
    for robot in robots:
        node.create_subscription(
            Odometry, f"/{robot}/odom", lambda message: heard.append(message.pose.pose.position.x), 10
        )
    print(flush=True)
    began, used = time.monotonic(), time.process_time()
    while not ended.is_set():
        rclpy.spin_once(node, timeout_sec=0.1)
    print((time.process_time() - used) / (time.monotonic() - began), len(heard) / (time.monotonic() - began))


def main() -> None:
    ended = threading.Event()
    threading.Thread(target=_wait, args=(ended,), daemon=True).start()
    rclpy.init()
    (publish if sys.argv[1] == "publish" else listen)(sys.argv[2:], ended)
    rclpy.try_shutdown()


def _wait(ended: threading.Event) -> None:
    sys.stdin.read()
    ended.set()


main()
