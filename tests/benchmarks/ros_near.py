"""Two robots that come too near to each other, run by ROS's interpreter: `ros_near.py ROUNDS SERVICE`.

Publishes their poses fifty times a second. In each round, a pose shows that they are near, and it prints how many
seconds later both had got their zeros. Then it has them play again.
"""

from __future__ import annotations

import sys
import time

import rclpy
from geometry_msgs.msg import PoseStamped, Twist
from std_srvs.srv import Trigger

PERIOD = 1 / 50
LIMIT = 60.0
MOVE = 0.5
"""Seconds for which robots move in each round."""
FAR, NEAR = 5.0, 0.7


def main() -> None:
    rounds, service = int(sys.argv[1]), sys.argv[2]
    rclpy.init()
    node = rclpy.create_node("camera")
    publishers = [node.create_publisher(PoseStamped, f"/{robot}/pose", 10) for robot in "ab"]
    moves = {"a": False, "b": False}
    stopped = {"a": 0.0, "b": 0.0}

    def hear(robot: str, twist: Twist) -> None:
        moving = bool(twist.linear.x or twist.angular.z)
        if moves[robot] and not moving:
            stopped[robot] = time.monotonic()
        moves[robot] = moving

    for robot in "ab":
        node.create_subscription(Twist, f"/{robot}/cmd_vel", lambda twist, robot=robot: hear(robot, twist), 10)
    play = node.create_client(Trigger, service)
    pose = PoseStamped()
    pose.header.frame_id, pose.pose.orientation.w = "map", 1.0

    def publish(apart: float) -> None:
        for publisher, x in zip(publishers, (0.0, apart), strict=True):
            pose.header.stamp = node.get_clock().now().to_msg()
            pose.pose.position.x = x
            publisher.publish(pose)

    def keep(seconds: float, apart: float, until: bool) -> bool:
        """Publish poses until both move or both stand; whether that came in time."""
        end = due = time.monotonic()
        while time.monotonic() < end + seconds:
            if all(moves.values()) if until else not any(moves.values()):
                return True
            if time.monotonic() >= due:
                publish(apart)
                due += PERIOD
            rclpy.spin_once(node, timeout_sec=0.001)
        return False

    for _ in range(rounds):
        if not keep(LIMIT, FAR, until=True):
            raise SystemExit("robots don't move")
        keep(MOVE, FAR, until=False)
        shown = time.monotonic()
        if not keep(LIMIT, NEAR, until=False):
            raise SystemExit("robots don't stop")
        print(max(stopped.values()) - shown, flush=True)
        keep(0.3, FAR, until=True)
        play.call_async(Trigger.Request())
    rclpy.try_shutdown()


main()
