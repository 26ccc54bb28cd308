"""Scanners of robots, run by ROS's interpreter: `ros_scanner.py SECONDS EVERY ROBOT...` publishes scans on /ROBOT/scan.

Twenty scans of 360 readings a second from each, all at different times. Something is close ahead in the first `EVERY`
scans, nothing in as many after that, and so on.
Begins once all are listened to, or after a line on standard input. Writes what it published, as JSON: robot, whether
something was close, and when (monotonic clock).
"""

from __future__ import annotations

import json
import math
import sys
import threading
import time

import rclpy
from rclpy.qos import qos_profile_sensor_data
from rclpy.serialization import serialize_message
from sensor_msgs.msg import LaserScan

RATE = 20


def main() -> None:
    seconds, every, robots = float(sys.argv[1]), int(sys.argv[2]), sys.argv[3:]
    rclpy.init()
    node = rclpy.create_node("scanner")
    publishers = [node.create_publisher(LaserScan, f"/{robot}/scan", qos_profile_sensor_data) for robot in robots]
    close, far = (serialize_message(_scan(reading)) for reading in (0.4, 3.0))
    asked = threading.Event()
    threading.Thread(target=_wait, args=(asked,), daemon=True).start()
    while not asked.is_set() and not all(publisher.get_subscription_count() for publisher in publishers):
        time.sleep(0.01)
    time.sleep(1)  # the listener's side follows
    begin, published = time.monotonic(), []
    for count in range(round(seconds * RATE)):
        is_close = count // every % 2 == 0
        for place, publisher in enumerate(publishers):
            time.sleep(max(begin + (count + place / len(robots)) / RATE - time.monotonic(), 0))
            published.append((robots[place], is_close, time.monotonic()))
            publisher.publish(close if is_close else far)
    print(json.dumps(published), flush=True)
    rclpy.try_shutdown()


def _wait(asked: threading.Event) -> None:
    if sys.stdin.readline():
        asked.set()


def _scan(ahead: float) -> LaserScan:
    ranges = [3.0] * 175 + [ahead] * 10 + [3.0] * 175
    scan = LaserScan(range_min=0.1, range_max=10.0, ranges=ranges)
    scan.angle_min, scan.angle_max, scan.angle_increment = -math.pi, math.pi, math.pi / 180
    scan.header.frame_id = "base_scan"
    return scan


main()
