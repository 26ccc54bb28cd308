"""Robots' nodes in ROS 2, run by ROS's interpreter until its input ends; messages.py has its messages.

Its arguments are the names of the robots.
"""

from __future__ import annotations

import json
import math
import sys
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

sys.path.append(str(Path(__file__).parents[1]))

import own_output  # noqa: F401, before any library may print
import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from rclpy.executors import SingleThreadedExecutor
from sensor_msgs.msg import BatteryState

if TYPE_CHECKING:
    from tests.ros.physics.messages import Battery, FromBridge, Seen, ToBridge, Wheels


def say(message: FromBridge) -> None:
    print(json.dumps(message), flush=True)


class Robot:
    """A robot's node, which listens on /NAME/cmd_vel, and publishes the values that it gets on /NAME/odom, world_pose,
    and battery_state."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._context = rclpy.Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node(f"{name}_base", context=self._context)
        self._odometry = self._node.create_publisher(Odometry, f"/{name}/odom", 10)
        self._poses = self._node.create_publisher(PoseStamped, f"/{name}/world_pose", 10)
        self._battery = self._node.create_publisher(BatteryState, f"/{name}/battery_state", 10)
        self._node.create_subscription(Twist, f"/{name}/cmd_vel", self._hear, 10)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._spinning = threading.Thread(target=self._executor.spin)
        self._spinning.start()

    def _hear(self, message: Any) -> None:
        linear, angular = message.linear.x, message.angular.z
        say({"type": "told", "robot": self._name, "linear": linear, "angular": angular, "at": time.monotonic()})

    def publish(self, message: Wheels | Seen | Battery) -> None:
        stamp = Time(sec=int(message["stamp"]), nanosec=int(message["stamp"] % 1 * 1e9))
        if message["type"] == "wheels":
            counted = Odometry(child_frame_id=f"{self._name}/base_link")
            counted.header.stamp, counted.header.frame_id = stamp, f"{self._name}/odom"
            _write(counted.pose.pose, message)
            counted.twist.twist.linear.x, counted.twist.twist.angular.z = message["linear"], message["angular"]
            self._odometry.publish(counted)
        elif message["type"] == "seen":
            pose = PoseStamped()
            pose.header.stamp, pose.header.frame_id = stamp, "world"
            _write(pose.pose, message)
            self._poses.publish(pose)
        else:
            battery = BatteryState(percentage=message["share"], present=True)
            battery.header.stamp = stamp
            self._battery.publish(battery)

    def close(self) -> None:
        self._executor.shutdown()
        self._node.destroy_node()
        rclpy.try_shutdown(context=self._context)
        self._spinning.join()  # a thread still inside rclpy when Python ends would abort the process


def _write(pose: Any, message: Wheels | Seen) -> None:
    pose.position.x, pose.position.y = message["x"], message["y"]
    pose.orientation.z, pose.orientation.w = math.sin(message["heading"] / 2), math.cos(message["heading"] / 2)


def main() -> None:
    names = sys.argv[1:]
    robots = {name: Robot(name) for name in names}
    say({"type": "ready"})
    for line in sys.stdin:
        message: ToBridge = json.loads(line)
        name = message["robot"]
        if message["type"] != "there":
            if name in robots:
                robots[name].publish(message)
        elif not message["there"] and name in robots:
            robots.pop(name).close()
        elif message["there"] and name not in robots:
            robots[name] = Robot(name)
    for robot in robots.values():
        robot.close()


main()
