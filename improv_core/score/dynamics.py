"""The motion of a simulated robot: exactly by its setpoints, or as motors and wheels allow. Standard library only."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import Profile

STEPS_PER_SECOND = 240
"""The time grid for everything inexact: acceleration and pushes. It makes the same program give the same poses."""
LINEAR_ACCELERATION, ANGULAR_ACCELERATION = 1.0, 5.0
"""m/s² and rad/s² of motors whose profile sets no limits: no particular machine, a bit quicker than a Create 3."""
NOISE_PERIOD = 0.1
"""Seconds for which the noise of a wheel stays the same."""


class Wheels(NamedTuple):
    """The meters that the wheels of a base roll for each meter that it counts, left and right, and their noise.

    `separation` is the distance between them in meters; `noise` is a standard deviation, as a share. The same `seed`
    gives the same noise at the same time.
    """

    left: float
    right: float
    separation: float
    noise: float
    seed: str

    def rolling(self, twist: Twist, period: int) -> Twist:
        """Return the real velocity of the base in a period of its noise when its wheels turn for `twist`.

        The wheels' speeds are v ± ω b/2 (Siegwart & Nourbakhsh, Introduction to Autonomous Mobile Robots, 3.2).
        """
        left, right = self.left, self.right
        if self.noise:
            chance = random.Random(f"{self.seed} {period}")
            left, right = left * chance.gauss(1, self.noise), right * chance.gauss(1, self.noise)
        both, turn = (left + right) / 2, (right - left) / 2
        yaw = twist.yaw * both + twist.x * turn * 2 / self.separation
        return Twist(twist.x * both + twist.yaw * turn * self.separation / 2, twist.y, twist.z, yaw)


class Motors(NamedTuple):
    """The limits of a base's motors: speeds in m/s and rad/s (None: no limit), accelerations per second.

    `wheels` is None if the base moves just as its motors turn. `calibration` is the profile of a base that drifts: its
    motors get the same commands as the real one's.
    """

    max_linear: float | None
    max_angular: float | None
    linear_acceleration: float
    angular_acceleration: float
    wheels: Wheels | None = None
    calibration: Profile | None = None

    def command_for(self, twist: Twist) -> Twist:
        """Return the twist for which the motors turn when the score asks for `twist`."""
        calibrated = self.calibration.calibrated(twist) if self.calibration else twist
        return calibrated.within(self.max_linear, self.max_angular)


def motors_of(profile: Profile, robot: str) -> Motors | None:
    """The motors of a robot with this profile; None if it is ideal. Beside a real one, it has only known limits."""
    if profile.dynamics == "ideal":
        return None
    linear, angular = (LINEAR_ACCELERATION, ANGULAR_ACCELERATION) if profile.dynamics == "motors" else (math.inf,) * 2
    left, right = profile.wheel_error
    wheels = Wheels(left, right, profile.wheel_separation, profile.noise, robot)
    return Motors(
        profile.max_linear,
        profile.max_angular,
        profile.max_linear_acceleration or linear,
        profile.max_angular_acceleration or angular,
        wheels if (left, right, profile.noise) != (1, 1, 0) else None,
        None if left == right == 1 else profile,  # a perfect base needs no correction
    )


@dataclass(frozen=True, slots=True)
class Motion:
    """A robot from `at` seconds on: its pose then, the twist of its motors, and its commanded twist.

    Ideally the two twists are the same. `real` is its true twist if its wheels don't roll as its motors turn.
    """

    at: float
    pose: Pose
    twist: Twist = STILL
    commanded: Twist = STILL
    real: Twist | None = None

    def pose_at(self, time: float) -> Pose:
        """Return its pose at a later time on the exact arc of its twist, never below the ground."""
        return self.pose.after(self.twist if self.real is None else self.real, time - self.at).above_ground()


def follow(motion: Motion, setpoints: Iterable[tuple[float, Twist]], to: float, motors: Motors | None) -> Motion:
    """Return the motion as of its latest change up to `to`, after all setpoints (times and twists) until then.

    Accelerating motors change all the time. Their steps end at grid times, at setpoints, and when a speed is reached.
    So the times of calls and their number make no difference.
    """
    for at, twist in setpoints:
        if at > to:
            break
        motion = _obey(_advance(motion, at, motors), at, twist, motors)
    return _advance(motion, to, motors)


def moving(at: float, pose: Pose, twist: Twist, commanded: Twist, motors: Motors | None) -> Motion:
    """Return the motion at a time, in seconds, of a robot whose motors turn for `twist`."""
    wheels = motors.wheels if motors else None
    real = wheels.rolling(twist, _period(at)) if wheels and twist != STILL else None
    return Motion(at, pose, twist, commanded, real)


def _obey(motion: Motion, at: float, twist: Twist, motors: Motors | None) -> Motion:
    commanded = motors.command_for(twist) if motors else twist
    if commanded == motion.commanded:
        return motion
    return moving(at, motion.pose_at(at), motion.twist if motors else commanded, commanded, motors)


def _advance(motion: Motion, to: float, motors: Motors | None) -> Motion:
    """The latest change of a motion up to `to`: its motors reach the commanded speed, and its wheels' noise varies."""
    while motors and motion.twist != motion.commanded and motion.at < to:
        motion = _piece(motion, to, motors)
    if motors and motors.wheels and motors.wheels.noise and motion.twist != STILL:
        while (end := (_period(motion.at) + 1) * NOISE_PERIOD) <= to:
            motion = moving(end, motion.pose_at(end), motion.twist, motion.commanded, motors)
    return motion


def _period(at: float) -> int:
    """Return the period of noise that a time is in, even if a product has been rounded."""
    return math.floor(at / NOISE_PERIOD + 1e-6)


def _piece(motion: Motion, to: float, motors: Motors) -> Motion:
    """One step at constant acceleration, up to `to` at most. Trapezoidal, with an error of second order in the step."""
    now, commanded = motion.twist, motion.commanded
    missing = math.hypot(commanded.x - now.x, commanded.y - now.y, commanded.z - now.z)
    linear, angular = missing / motors.linear_acceleration, abs(commanded.yaw - now.yaw) / motors.angular_acceleration
    step_end = (math.floor(motion.at * STEPS_PER_SECOND + 1e-6) + 1) / STEPS_PER_SECOND
    reached = [motion.at + needed for needed in (linear, angular) if motion.at + needed > motion.at]
    if not reached:  # the difference is too small to take any time
        return moving(motion.at, motion.pose, commanded, commanded, motors)
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
    pose = moving(motion.at, motion.pose, mean, commanded, motors).pose_at(end)
    return moving(end, pose, then, commanded, motors)
