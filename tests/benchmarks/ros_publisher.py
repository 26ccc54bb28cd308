"""A plain script that publishes Twists without Improv, run by ROS's interpreter: `ros_publisher.py SECONDS TOPIC...`.

Waits for listeners, prints the time at which it begins (monotonic clock), and publishes to all topics 20 times a
second, ready messages at absolute times, another velocity each second.
"""

from __future__ import annotations

import sys
import time

import rclpy
from geometry_msgs.msg import Twist

RATE = 20

rclpy.init()
node = rclpy.create_node("plain_steady")
seconds, topics = float(sys.argv[1]), sys.argv[2:]
publishers = [node.create_publisher(Twist, topic, 10) for topic in topics]
while not all(publisher.get_subscription_count() for publisher in publishers):
    time.sleep(0.01)
time.sleep(1)  # the listener's side follows
forward, left = Twist(), Twist()
forward.linear.x = left.angular.z = 1.0
begin = time.monotonic() + 0.1
print(begin, flush=True)
for count in range(round(seconds * RATE)):
    time.sleep(max(begin + count / RATE - time.monotonic(), 0))
    for publisher in publishers:
        publisher.publish(left if count // RATE % 2 else forward)
time.sleep(0.5)
rclpy.try_shutdown()
