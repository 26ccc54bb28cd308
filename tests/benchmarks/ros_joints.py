"""Joints in ROS 2, run by ROS's interpreter.

`states TOPIC` prints, for each message with the positions of joints, its time (monotonic clock) and all velocities.
`loop ROBOTS JOINTS SECONDS RATE` publishes trajectories without Improv: ready messages at absolute times, others each
second. `listen ROBOTS JOINTS SECONDS` publishes the joints of robots at 0, waits for trajectories, and prints the robot
of each that moves otherwise than the one before, and the time of its arrival by Fast DDS's own stamp (Unix time).
"""

from __future__ import annotations

import sys
import time
from typing import Any

import rclpy
from builtin_interfaces.msg import Duration
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

TOPIC = "/arm{}/all_controller/joint_trajectory"
PERIOD = 0.02


def names(count: int) -> list[str]:
    return [f"joint{number}" for number in range(count)]


def states(topic: str) -> None:
    node = rclpy.create_node("states")

    def hear(message: Any) -> None:
        print(time.monotonic(), *message.velocity, flush=True)

    node.create_subscription(JointState, topic, hear, 10)
    rclpy.spin(node)


def loop(robots: int, joints: int, seconds: float, rate: float) -> None:
    node = rclpy.create_node("plain_loop")
    publishers = [node.create_publisher(JointTrajectory, TOPIC.format(robot), 10) for robot in range(robots)]
    ready = [serialize_message(trajectory(joints, speed)) for speed in (1.0, -1.0)]
    while not all(each.get_subscription_count() for each in publishers):
        time.sleep(0.05)
    time.sleep(1.0)
    begin = time.monotonic()
    for count in range(round(seconds * rate)):
        time.sleep(max(begin + count / rate - time.monotonic(), 0))
        message = ready[int(count / rate) % 2]
        for publisher in publishers:
            publisher.publish(message)
    time.sleep(0.5)


def trajectory(joints: int, speed: float) -> JointTrajectory:
    points = [
        JointTrajectoryPoint(
            positions=[speed * seconds] * joints,
            velocities=[speed if seconds < 0.3 else 0.0] * joints,
            time_from_start=Duration(nanosec=round(seconds * 1e9)),
        )
        for seconds in (0.0, 0.2, 0.3)
    ]
    return JointTrajectory(joint_names=names(joints), points=points)


def listen(robots: int, joints: int, seconds: float) -> None:
    node = rclpy.create_node("joints_listener")
    hears = [
        node.create_subscription(JointTrajectory, TOPIC.format(robot), lambda message: None, 100, raw=True)
        for robot in range(robots)
    ]
    publishers = [node.create_publisher(JointState, f"/arm{robot}/joint_states", 10) for robot in range(robots)]
    where = JointState(name=names(joints), position=[0.0] * joints)
    latest: dict[int, float] = {}
    print("ready", flush=True)
    began = due = time.monotonic()
    while time.monotonic() < began + seconds:
        if not any(latest.values()) and time.monotonic() >= due:
            due += PERIOD
            for publisher in publishers:
                publisher.publish(where)
        for robot, subscription in enumerate(hears):
            with subscription.handle:
                while taken := subscription.handle.take_message(JointTrajectory, True):
                    message, info = taken
                    speed = deserialize_message(message, JointTrajectory).points[0].velocities[0]
                    if speed and speed != latest.get(robot):
                        print(robot, info["received_timestamp"] / 1e9, flush=True)
                    latest[robot] = speed or latest.get(robot, 0.0)
        time.sleep(0.005)


rclpy.init()
command, *arguments = sys.argv[1:]
if command == "states":
    states(arguments[0])
elif command == "loop":
    loop(int(arguments[0]), int(arguments[1]), float(arguments[2]), float(arguments[3]))
else:
    listen(int(arguments[0]), int(arguments[1]), float(arguments[2]))
