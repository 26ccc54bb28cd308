"""Somebody else in ROS, run by ROS's interpreter: prints what arrives, one JSON line each, until its input ends.

Listens on topics, and if asked to publishes on one, sends /clock, or offers a service that resets as turtlesim's does:
every listener is made anew.
"""

import argparse
import json
import math
import sys
import threading
import time

import rclpy
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String
from std_srvs.srv import Empty

parser = argparse.ArgumentParser()
parser.add_argument("topics", nargs="*")
parser.add_argument("--stamped", action="store_const", const=TwistStamped, dest="type", default=Twist)
parser.add_argument("--string", action="store_const", const=String, dest="type")
parser.add_argument("--odometry", action="store_const", const=Odometry, dest="type")
parser.add_argument("--pose", action="store_const", const=PoseStamped, dest="type")
parser.add_argument("--transient", action="store_const", const=DurabilityPolicy.TRANSIENT_LOCAL, dest="durability")
parser.add_argument("--best-effort", action="store_const", const=ReliabilityPolicy.BEST_EFFORT, dest="reliability")
parser.add_argument("--publish")
parser.add_argument("--clock", type=float)
parser.add_argument("--reset")
parser.add_argument("--deaf", action="store_true", help="a reset that is never answered")
parser.add_argument("--name", default="listener")
options = parser.parse_args()


def say(**values):
    print(json.dumps(values), flush=True)


def hear(topic, message):
    if options.type in (Odometry, PoseStamped):
        pose = message.pose.pose if options.type is Odometry else message.pose
        heading = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
        say(topic=topic, at=time.monotonic(), x=pose.position.x, y=pose.position.y, heading=heading)
        return
    stamped = options.type is TwistStamped
    velocity = message.twist if stamped else message
    linear, angular = velocity.linear, velocity.angular
    stamp = {"stamp": message.header.stamp.sec + message.header.stamp.nanosec / 1e9} if stamped else {}
    say(topic=topic, at=time.monotonic(), x=linear.x, y=linear.y, z=linear.z, yaw=angular.z, **stamp)


def listen():
    qos = QoSProfile(
        depth=100,
        durability=options.durability or DurabilityPolicy.VOLATILE,
        reliability=options.reliability or ReliabilityPolicy.RELIABLE,
    )
    return [
        node.create_subscription(options.type, topic, lambda message, topic=topic: hear(topic, message), qos)
        for topic in options.topics
    ]


def reset(_, response):
    global listeners
    say(topic=options.reset, at=time.monotonic())
    if options.deaf:
        ended.wait()
        return response
    for listener in listeners:
        node.destroy_subscription(listener)
    listeners = listen()
    return response


def count_publishers():
    global publishers
    now = max((node.count_publishers(topic) for topic in options.topics), default=0)
    if now != publishers:
        publishers = now
        say(publishers=now)


publishers = 0
ended = threading.Event()
rclpy.init()
node = rclpy.create_node(options.name)
if options.reset:
    node.create_service(Empty, options.reset, reset)
listeners = listen()
if options.publish:
    node.create_publisher(options.type, options.publish, 10)
if options.clock is not None:
    clock = node.create_publisher(Clock, "/clock", 10)
    now = Time(nanoseconds=int(options.clock * 1e9)).to_msg()
    node.create_timer(0.01, lambda: clock.publish(Clock(clock=now)))
node.create_timer(0.05, count_publishers)
spinning = threading.Thread(target=rclpy.spin, args=(node,))
spinning.start()
say(ready=True)
sys.stdin.read()
ended.set()
# A thread still inside rclpy when Python ends would abort the process.
rclpy.try_shutdown()
spinning.join()
