"""Publishes what tf knows of robots as poses, on /ROBOT/pose: `python3 poses_from_tf.py anna bert`.

For a sourced ROS 2 with tf2_ros_py and tf2_msgs; see docs/ros.md.
"""

import sys

import rclpy
from geometry_msgs.msg import PoseStamped
from rclpy.node import Node
from rclpy.time import Time
from tf2_ros import Buffer, TransformException, TransformListener


class PosesFromTf(Node):
    """Publishes the poses of `ROBOT/base_link` in the frame `map`, twenty times a second at most."""

    def __init__(self, robots):
        super().__init__("poses_from_tf")
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self)
        self.outputs = {robot: self.create_publisher(PoseStamped, f"/{robot}/pose", 10) for robot in robots}
        self.stamps = {}
        self.create_timer(0.05, self.publish)

    def publish(self):
        """Publish the poses that are new."""
        for robot, output in self.outputs.items():
            try:
                found = self.buffer.lookup_transform("map", f"{robot}/base_link", Time())
            except TransformException:
                continue  # tf doesn't know it yet
            if found.header.stamp == self.stamps.get(robot):
                continue  # an old pose must not look like a new one
            self.stamps[robot] = found.header.stamp
            pose = PoseStamped(header=found.header)
            place, position = found.transform.translation, pose.pose.position
            position.x, position.y, position.z = place.x, place.y, place.z
            pose.pose.orientation = found.transform.rotation
            output.publish(pose)


rclpy.init()
rclpy.spin(PosesFromTf(sys.argv[1:]))
