"""A node of rclpy that has one publisher, run by ROS's interpreter, until its input ends: nothing needs less memory."""

from __future__ import annotations

import sys

import rclpy
from geometry_msgs.msg import Twist

rclpy.init()
publisher = rclpy.create_node("bare").create_publisher(Twist, "/bare/cmd_vel", 10)
print("ready", flush=True)
sys.stdin.read()
rclpy.try_shutdown()
