"""A robot that is measured on its own machine, run by ROS's interpreter: `ros_beside.py ROBOT X`.

Publishes its pose fifty times a second. A line on standard input is another x, in meters, which it publishes at once.
Prints `shown`, `moves`, or `stands`, and the time in seconds of the monotonic clock. Ends with its input.
"""

from __future__ import annotations

import os
import select
import sys
import time

import rclpy
from geometry_msgs.msg import PoseStamped, Twist

PERIOD = 1 / 50


def main() -> None:
    robot, x = sys.argv[1], float(sys.argv[2])
    rclpy.init()
    node = rclpy.create_node("camera")
    publisher = node.create_publisher(PoseStamped, f"/{robot}/pose", 10)
    moves = False
    pose = PoseStamped()
    pose.header.frame_id, pose.pose.orientation.w = "map", 1.0

    def say(what: str) -> None:
        print(what, time.monotonic(), flush=True)

    def hear(twist: Twist) -> None:
        nonlocal moves
        moving = bool(twist.linear.x or twist.angular.z)
        if moving != moves:
            say("moves" if moving else "stands")
        moves = moving

    node.create_subscription(Twist, f"/{robot}/cmd_vel", hear, 10)
    due = time.monotonic()
    while True:
        if select.select([0], [], [], 0)[0]:
            if not (line := os.read(0, 100)):
                break
            x, due = float(line), time.monotonic()
            say("shown")
        if time.monotonic() >= due:
            pose.header.stamp = node.get_clock().now().to_msg()
            pose.pose.position.x = x
            publisher.publish(pose)
            due += PERIOD
        rclpy.spin_once(node, timeout_sec=0.001)
    rclpy.try_shutdown()


main()
