"""Robots' nodes in ROS 2, run by ROS's interpreter until its input ends.

Its arguments are the names of the robots. It prints lines of JSON: an empty list when it has made all nodes, then the
robot, linear and angular velocity, and monotonic time of each velocity that it hears. Lines of its input are the robot,
x, y, heading, and Unix time of a pose to publish, or a robot and whether it has to have a node.
"""

from __future__ import annotations

import json
import math
import sys
import threading
import time
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).parents[1]))

import own_output  # noqa: F401, before any library may print
import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Twist
from rclpy.executors import SingleThreadedExecutor


def say(*what: str | float) -> None:
    print(json.dumps(what), flush=True)


class Robot:
    """A robot's node, which listens on /NAME/cmd_vel, and publishes poses on /NAME/world_pose."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node(f"{name}_base", context=self._context)
        self._poses = self._node.create_publisher(PoseStamped, f"/{name}/world_pose", 10)
        self._node.create_subscription(Twist, f"/{name}/cmd_vel", self._hear, 10)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._spinning = threading.Thread(target=self._executor.spin)
        self._spinning.start()

    def _hear(self, message: Any) -> None:
        say(self._name, message.linear.x, message.angular.z, time.monotonic())

    def publish(self, x: float, y: float, heading: float, stamp: float) -> None:
        message = PoseStamped()
        message.header.frame_id = "world"
        message.header.stamp = Time(sec=int(stamp), nanosec=int(stamp % 1 * 1e9))
        message.pose.position.x, message.pose.position.y = x, y
        message.pose.orientation.z, message.pose.orientation.w = math.sin(heading / 2), math.cos(heading / 2)
        self._poses.publish(message)

    def close(self) -> None:
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.try_shutdown(context=self._context)
        self._spinning.join()  # a thread still inside rclpy when Python ends would abort the process


def main() -> None:
    robots = {name: Robot(name) for name in sys.argv[1:]}
    say()
    for line in sys.stdin:
        name, *what = json.loads(line)
        if what == [True]:
            robots[name] = Robot(name)
        elif what == [False]:
            robots.pop(name).close()
        elif name in robots:
            robots[name].publish(*what)
    for robot in robots.values():
        robot.close()


main()
