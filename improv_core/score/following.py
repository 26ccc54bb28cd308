"""Following: feedback that pulls a robot that drifts back to its ideal path. Standard library only.

The law is the nonlinear, Lyapunov-based one of B. Siciliano, L. Sciavicco, L. Villani, and G. Oriolo, Robotics:
Modelling, Planning and Control, Springer 2009, 11.6.1, after C. Samson. With the errors e1 ahead, e2 to the left, and
e3 of the heading, in the robot's frame, and the ideal velocities v and w, the robot's command is

    v cos e3 + k1 e1   and   w + k2 v e2 sin(e3)/e3 + k3 e3

which takes e1 and e3 to 0 for any k1, k2, k3 > 0, and e2 too while v is not 0.
"""

from __future__ import annotations

import math

from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import Profile

SHARE = 0.1
"""The largest correction of a velocity, as a share of the robot's limits."""
OLDEST = 0.2
"""Seconds after which a pose is too old for a correction, or to show where a robot stands."""
GAIN = 2.0
"""k1 and k3, per second. k2 is such that an error to the side is critically damped at the highest speed."""
RESTS = 0.25
"""Seconds after the end of a turn from which on a robot no longer turns: its motors need time, and its base recoils."""
MAX_LATE = 0.25
"""The largest lateness that is learned: a robot that is off by more was held or pushed."""
SAFE_DELAY = math.pi / 4 / GAIN
"""Seconds of delay that the feedback may have: half of those with which e' = -k e would begin to swing without end."""


def correction(
    ideal: Pose, twist: Twist, measured: Pose, limits: tuple[float, float], turning_radius: float | None = None
) -> Twist:
    """Return the correction of a robot's ideal `twist` toward its ideal pose, within its limits in m/s and rad/s.

    A robot that should stand still is not moved. The sum is no tighter curve than a car's `turning_radius`, in meters.
    """
    if twist == STILL:
        return STILL
    linear, angular = limits
    error = measured.inverse().then(ideal)
    turn = math.remainder(error.heading, math.tau)
    steer = (GAIN / 2 / linear) ** 2 * twist.x * error.y * (math.sin(turn) / turn if turn else 1.0)
    ahead = twist.x * (math.cos(turn) - 1) + GAIN * error.x
    added = Twist(_clamped(ahead, SHARE * linear), yaw=_clamped(steer + GAIN * turn, SHARE * angular))
    if turning_radius is None:
        return added
    tightest = abs(twist.x + added.x) / turning_radius
    return Twist(added.x, yaw=_clamped(twist.yaw + added.yaw, tightest) - twist.yaw)


def refusal(profile: Profile) -> str | None:
    """Return the reason why a robot with this profile can't follow, and what to do; None if it can."""
    if not {"forward", "turn"} <= {*profile.motions} or {"strafe", "climb"} & {*profile.motions}:
        return 'works only with `motions = ["forward", "turn"]` in the profile'
    if not profile.max_linear or not profile.max_angular:
        return "corrects by a tenth of the limits: set `max_linear` and `max_angular` in the profile"
    accelerations = (profile.max_linear_acceleration, profile.max_angular_acceleration)
    limits = zip((profile.max_linear, profile.max_angular), accelerations, strict=True)
    slowest = max(SHARE * limit / acceleration if acceleration else 0.0 for limit, acceleration in limits)
    if (delay := OLDEST + 1 / profile.command_rate + slowest) > SAFE_DELAY:
        late = f"would correct up to {delay:.2f} s too late, and from {SAFE_DELAY:.2f} s on the robot may swing"
        return f"{late}: raise `command_rate` in the profile, or its accelerations if they are too low"
    return None


def accelerated(speed: Twist, wanted: Twist, seconds: float, accelerations: tuple[float, float]) -> Twist:
    """Return the speed of motors some seconds on the way from `speed` to `wanted`, at m/s² and rad/s²."""
    linear, angular = (acceleration * max(seconds, 1e-9) for acceleration in accelerations)
    x, yaw = wanted.x - speed.x, wanted.yaw - speed.yaw
    return Twist(speed.x + _clamped(x, linear), yaw=speed.yaw + _clamped(yaw, angular))


def before_stopping(pose: Pose, speed: Twist, accelerations: tuple[float, float], late: float = 0.0) -> Pose:
    """Return the pose at which motors at this speed have to begin to stop, so that the robot comes to rest at `pose`.

    They fall behind by as much when they start, so a robot that is there has no error. After that it turns for `late`
    more seconds at its speed.
    """
    linear, angular = accelerations
    turn = speed.yaw * late + speed.yaw * abs(speed.yaw) / 2 / angular
    return pose.then(Pose(-speed.x * abs(speed.x) / 2 / linear, heading=-turn))


def learned(late: float, error: float, speed: float, limit: float) -> float:
    """Return how late a robot is, in seconds, after a turn at this `speed` that has left an `error`, both in radians.

    A base that falls short of its speed has a negative lateness: the pose where it should be is ahead of its ideal one.
    Each turn corrects the next (D. A. Bristow, M. Tharayil, and A. G. Alleyne, A survey of iterative learning control,
    IEEE Control Systems 26(3), 2006). A slow turn, or an error that no base makes by itself, counts for nothing.
    """
    if abs(speed) < SHARE * limit or abs(error) > MAX_LATE * abs(speed):
        return late
    return _clamped(late - error / speed, MAX_LATE)


def _clamped(value: float, most: float) -> float:
    return max(-most, min(most, value))
