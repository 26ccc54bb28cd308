"""A real subscriber, run by ROS's interpreter: prints what arrives, one JSON line each, until its input ends."""

import argparse
import json
import sys
import threading
import time

import rclpy
from geometry_msgs.msg import Twist, TwistStamped

parser = argparse.ArgumentParser()
parser.add_argument("topics", nargs="+")
parser.add_argument("--stamped", action="store_true")
options = parser.parse_args()


def say(**values):
    print(json.dumps(values), flush=True)


def hear(topic, message):
    velocity = message.twist if options.stamped else message
    linear, angular = velocity.linear, velocity.angular
    say(topic=topic, at=time.monotonic(), x=linear.x, y=linear.y, z=linear.z, yaw=angular.z)


rclpy.init()
node = rclpy.create_node("listener")
for topic in options.topics:
    node.create_subscription(
        TwistStamped if options.stamped else Twist, topic, lambda message, topic=topic: hear(topic, message), 100
    )
spinning = threading.Thread(target=rclpy.spin, args=(node,))
spinning.start()
say(ready=True)
sys.stdin.read()
# A thread still inside rclpy when Python ends would abort the process.
rclpy.try_shutdown()
spinning.join()
