"""Twists and poses in SI units, in the axes of REP-103: x forward, y left, z up, yaw counterclockwise."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TypeVar

Degrees = TypeVar("Degrees", float, Fraction)


@dataclass(frozen=True, slots=True)
class Twist:
    """A velocity in the robot's own frame: x, y, z in m/s, yaw in rad/s."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    yaw: float = 0.0

    def within(self, max_linear: float | None, max_angular: float | None) -> Twist:
        """Return this twist, or a slower one if it exceeds a limit (m/s in any direction, rad/s; None: no limit).

        One factor scales all components, so a curve keeps its shape.
        """
        slower, factor = self, 1.0
        while (over := _times_over(slower, max_linear, max_angular)) > 1:
            # Rounding may leave it barely over the limit, where dividing by `over` changes nothing.
            factor = min(factor / over, math.nextafter(factor, 0))
            slower = Twist(self.x * factor, self.y * factor, self.z * factor, self.yaw * factor)
        return slower

    def plus(self, other: Twist) -> Twist:
        """Return both velocities at once."""
        return Twist(self.x + other.x, self.y + other.y, self.z + other.z, self.yaw + other.yaw)

    def times(self, factor: float) -> Twist:
        """Return the same direction, this many times as fast."""
        return Twist(self.x * factor, self.y * factor, self.z * factor, self.yaw * factor)

    def balanced(self, left_right: float, separation: float) -> Twist:
        """Return this twist as a base needs it whose left wheel rolls `left_right` times as far as its right one.

        `separation` is the distance between the wheels, in meters. Each wheel's speed, v - ω b/2 and v + ω b/2, is
        multiplied by a factor so that both roll equally far, and the factors' mean is 1. These are the factors with
        which UMBmark corrects odometry, exchanged (Borenstein & Feng, Measurement and Correction of Systematic Odometry
        Errors in Mobile Robots, IEEE Transactions on Robotics and Automation 12(6), 1996).
        """
        share = (left_right - 1) / (left_right + 1)
        x, yaw = self.x + self.yaw * separation / 2 * share, self.yaw + self.x * 2 / separation * share
        return Twist(x, self.y, self.z, yaw)


def _times_over(twist: Twist, max_linear: float | None, max_angular: float | None) -> float:
    linear = math.hypot(twist.x, twist.y, twist.z) / max_linear if max_linear is not None else 0.0
    angular = abs(twist.yaw) / max_angular if max_angular is not None else 0.0
    return max(linear, angular)


STILL = Twist()


@dataclass(frozen=True, slots=True)
class Pose:
    """A place in the world: x, y, z in meters, heading in radians, counterclockwise from the x axis."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    heading: float = 0.0

    def after(self, twist: Twist, seconds: float) -> Pose:
        """Return the pose after holding `twist` for `seconds`: the exact arc, not a chain of short lines.

        With a = yaw * seconds, the robot-frame displacement is the integral of the turning velocity, (x sin a - y (1 -
        cos a), x (1 - cos a) + y sin a) / yaw (Lynch & Park, Modern Robotics, 3.3.3).
        """
        angle = twist.yaw * seconds
        # sin(a)/a and (1-cos(a))/a. Near zero, their series avoid 0/0 and cancellation.
        if abs(angle) < 1e-4:
            along, across = 1 - angle * angle / 6, angle / 2
        else:
            along, across = math.sin(angle) / angle, (1 - math.cos(angle)) / angle
        dx = (twist.x * along - twist.y * across) * seconds
        dy = (twist.x * across + twist.y * along) * seconds
        return self.then(Pose(dx, dy, twist.z * seconds, angle))

    def inverse(self) -> Pose:
        """Return the pose of the world in the frame of this pose: `pose.then(pose.inverse())` is the origin."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return Pose(-cos * self.x - sin * self.y, sin * self.x - cos * self.y, -self.z, -self.heading)

    def above_ground(self) -> Pose:
        """Return this pose, or the one above it on the ground: no robot sinks into it."""
        return self if self.z >= 0 else replace(self, z=0.0)

    def apart(self, other: Pose) -> tuple[float, float]:
        """Return the distance to another pose, in meters, and the angle between both, in radians from 0 to π."""
        far = math.dist((self.x, self.y, self.z), (other.x, other.y, other.z))
        return far, abs(math.remainder(self.heading - other.heading, math.tau))

    def then(self, other: Pose) -> Pose:
        """Return the composition of two poses: `other` is relative to this pose; the result is in the world frame."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return Pose(
            self.x + cos * other.x - sin * other.y,
            self.y + sin * other.x + cos * other.y,
            self.z + other.z,
            self.heading + other.heading,
        )


def wrapped(degrees: Degrees) -> Degrees:
    """Return the same direction in degrees, above -180 and at most 180."""
    return 180 - (180 - degrees) % 360
