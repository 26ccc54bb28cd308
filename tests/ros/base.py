"""A simulated base, run by ROS's interpreter: it obeys velocities and drifts as a real one does.

It listens on /NAME/cmd_vel, and fifty times a second publishes /NAME/odom, the pose by its wheels' encoders, and
/NAME/true_pose, its real pose. It prints a line once it listens, and its real pose when its input ends.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Any

STEP = 0.005
"""Seconds between two changes of speeds."""
ODOMETRY_PERIOD = 0.02
NOISE_PERIOD = 0.1
"""Seconds for which the noise of a wheel stays the same."""
TIMEOUT = 0.5
"""Seconds without a command after which it stops, as a Create 3 and diff_drive_controller do."""
ACCELERATION, TURNING_ACCELERATION = 0.9, 7.725
"""m/s² and rad/s² of a Create 3."""
SEPARATION = 0.233
"""Meters between the wheels of a Create 3."""


@dataclass
class Planar:
    """A pose on the floor: meters and radians."""

    x: float
    y: float
    heading: float

    def move(self, linear: float, angular: float) -> None:
        """Move for one step, along the chord of its arc."""
        middle = self.heading + angular * STEP / 2
        self.x += linear * STEP * math.cos(middle)
        self.y += linear * STEP * math.sin(middle)
        self.heading += angular * STEP


class Base:
    """Two wheels and their encoders. Times are monotonic, in seconds."""

    def __init__(self, options: argparse.Namespace, now: float) -> None:
        self._errors: tuple[float, float] = tuple(options.wheel_error)
        self._noise, self._loss = options.noise, options.loss
        self._lots, self._rolling = random.Random(f"loss {options.seed}"), random.Random(f"noise {options.seed}")
        self._began, self._steps = now, 0
        self._wanted, self._heard = (0.0, 0.0), -math.inf
        self._wheels = self._errors
        self.linear = self.angular = 0.0
        self.counted = Planar(0.0, 0.0, 0.0)
        self.true = Planar(*options.start)

    def command(self, linear: float, angular: float, now: float) -> None:
        if self._lots.random() >= self._loss:
            self.advance(now)
            self._wanted, self._heard = (linear, angular), now

    def advance(self, now: float) -> None:
        """Make all steps that are due."""
        while (at := self._began + (self._steps + 1) * STEP) <= now:
            linear, angular = self._wanted if at < self._heard + TIMEOUT else (0.0, 0.0)
            self.linear = _toward(self.linear, linear, ACCELERATION * STEP)
            self.angular = _toward(self.angular, angular, TURNING_ACCELERATION * STEP)
            self.counted.move(self.linear, self.angular)
            if self._steps % round(NOISE_PERIOD / STEP) == 0:
                left, right = self._errors
                self._wheels = left * self._rolling.gauss(1, self._noise), right * self._rolling.gauss(1, self._noise)
            half = self.angular * SEPARATION / 2
            left, right = (self.linear - half) * self._wheels[0], (self.linear + half) * self._wheels[1]
            self.true.move((left + right) / 2, (right - left) / SEPARATION)
            self._steps += 1


def _toward(now: float, wanted: float, most: float) -> float:
    return now + max(-most, min(most, wanted - now))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("name")
    parser.add_argument("--start", type=float, nargs=3, default=(0.0, 0.0, 0.0), help="x, y, and heading")
    parser.add_argument("--wheel-error", type=float, nargs=2, default=(1.0, 1.0))
    parser.add_argument("--noise", type=float, default=0.01)
    parser.add_argument("--loss", type=float, default=0.05, help="the share of commands that get lost")
    parser.add_argument("--ahead", type=int, default=0, help="seconds by which its clock is ahead of ours")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--delay", type=float, default=0.0, help="seconds by which its true poses come late")
    parser.add_argument("--rests", action="store_true", help="end once it stands")
    options = parser.parse_args()

    import own_output  # noqa: F401, before any library may print
    import rclpy
    from geometry_msgs.msg import PoseStamped, Twist
    from nav_msgs.msg import Odometry

    rclpy.init()
    node = rclpy.create_node(f"{options.name}_base")
    base = Base(options, time.monotonic())
    odometry = node.create_publisher(Odometry, f"/{options.name}/odom", 10)
    true_pose = node.create_publisher(PoseStamped, f"/{options.name}/true_pose", 10)

    late: deque[tuple[float, Any]] = deque()  # true poses that are yet to be published, and when

    def hear(message: Any) -> None:
        base.command(message.linear.x, message.angular.z, time.monotonic())

    def publish() -> None:
        base.advance(time.monotonic())
        stamp = node.get_clock().now().to_msg()
        stamp.sec += options.ahead
        counted = Odometry(child_frame_id="base_link")
        counted.header.stamp, counted.header.frame_id = stamp, "odom"
        _write(counted.pose.pose, base.counted)
        counted.twist.twist.linear.x, counted.twist.twist.angular.z = base.linear, base.angular
        odometry.publish(counted)
        true = PoseStamped()
        true.header.stamp, true.header.frame_id = stamp, "world"
        _write(true.pose, base.true)
        late.append((time.monotonic() + options.delay, true))
        while late and late[0][0] <= time.monotonic():
            _, true = late.popleft()
            true_pose.publish(true)

    node.create_subscription(Twist, f"/{options.name}/cmd_vel", hear, 10)
    node.create_timer(ODOMETRY_PERIOD, publish)
    spinning = threading.Thread(target=rclpy.spin, args=(node,))
    spinning.start()
    print("true", flush=True)
    sys.stdin.read()
    while options.rests and (base.linear or base.angular):
        time.sleep(STEP)
    # A thread still inside rclpy when Python ends would abort the process.
    rclpy.try_shutdown()
    spinning.join()
    base.advance(time.monotonic())
    print(base.true.x, base.true.y, base.true.heading, flush=True)


def _write(pose: Any, planar: Planar) -> None:
    pose.position.x, pose.position.y = planar.x, planar.y
    pose.orientation.z, pose.orientation.w = math.sin(planar.heading / 2), math.cos(planar.heading / 2)


if __name__ == "__main__":
    main()
