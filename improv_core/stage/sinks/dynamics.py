"""How a simulated robot follows its setpoints: exactly, or as its motors allow. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import Profile

STEPS_PER_SECOND = 240
"""The time grid for everything inexact: acceleration and pushes. It makes the same program give the same poses."""
LINEAR_ACCELERATION, ANGULAR_ACCELERATION = 1.0, 5.0
"""m/s² and rad/s² of motors whose profile sets no limits: no particular machine, a bit quicker than a Create 3."""


class Motors(NamedTuple):
    """What the motors of a base can do: speeds in m/s and rad/s (None: no limit), accelerations per second."""

    max_linear: float | None
    max_angular: float | None
    linear_acceleration: float
    angular_acceleration: float


def motors_of(profile: Profile) -> Motors | None:
    """The motors of a profile; None if it is ideal."""
    if profile.dynamics != "motors":
        return None
    return Motors(
        profile.max_linear,
        profile.max_angular,
        profile.max_linear_acceleration or LINEAR_ACCELERATION,
        profile.max_angular_acceleration or ANGULAR_ACCELERATION,
    )


@dataclass(frozen=True, slots=True)
class Motion:
    """A robot from `at` seconds on: its pose then, its twist, and its commanded twist (ideally the same)."""

    at: float
    pose: Pose
    twist: Twist = STILL
    commanded: Twist = STILL

    def pose_at(self, time: float) -> Pose:
        """Its pose at a later time on the exact arc, as long as its twist stays the same."""
        return self.pose.after(self.twist, time - self.at)


def follow(motion: Motion, setpoints: Iterable[tuple[float, Twist]], to: float, motors: Motors | None) -> Motion:
    """The motion as of its latest change up to `to`, after all setpoints (times and twists) until then.

    Accelerating motors change all the time. Their steps end at grid times, at setpoints, and when a speed is reached.
    So it makes no difference when or how often this is called.
    """
    for at, twist in setpoints:
        if at > to:
            break
        motion = _obey(_speed_up(motion, at, motors), at, twist, motors)
    return _speed_up(motion, to, motors)


def _obey(motion: Motion, at: float, twist: Twist, motors: Motors | None) -> Motion:
    commanded = twist.within(motors.max_linear, motors.max_angular) if motors else twist
    if commanded == motion.commanded:
        return motion
    return Motion(at, motion.pose_at(at), motion.twist if motors else commanded, commanded)


def _speed_up(motion: Motion, to: float, motors: Motors | None) -> Motion:
    """The motion when its commanded speed is reached, or at `to`. A motion at constant speed stays as it is."""
    while motors and motion.twist != motion.commanded and motion.at < to:
        motion = _piece(motion, to, motors)
    return motion


def _piece(motion: Motion, to: float, motors: Motors) -> Motion:
    """One step at constant acceleration, up to `to` at most. Trapezoidal, with an error of second order in the step."""
    now, commanded = motion.twist, motion.commanded
    missing = math.hypot(commanded.x - now.x, commanded.y - now.y, commanded.z - now.z)
    linear, angular = missing / motors.linear_acceleration, abs(commanded.yaw - now.yaw) / motors.angular_acceleration
    step_end = (math.floor(motion.at * STEPS_PER_SECOND + 1e-6) + 1) / STEPS_PER_SECOND
    reached = [motion.at + needed for needed in (linear, angular) if motion.at + needed > motion.at]
    if not reached:  # the difference is too small to take any time
        return replace(motion, twist=commanded)
    end = min(to, step_end, *reached)
    seconds = end - motion.at
    share = 1.0 if seconds >= linear else seconds / linear
    turn = 1.0 if seconds >= angular else seconds / angular
    then = Twist(
        now.x + (commanded.x - now.x) * share if share < 1 else commanded.x,
        now.y + (commanded.y - now.y) * share if share < 1 else commanded.y,
        now.z + (commanded.z - now.z) * share if share < 1 else commanded.z,
        now.yaw + (commanded.yaw - now.yaw) * turn if turn < 1 else commanded.yaw,
    )
    mean = Twist((now.x + then.x) / 2, (now.y + then.y) / 2, (now.z + then.z) / 2, (now.yaw + then.yaw) / 2)
    return Motion(end, motion.pose.after(mean, seconds), then, commanded)
