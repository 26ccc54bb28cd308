"""The distance that robots still move after a command to stand. Standard library only."""

from __future__ import annotations

from improv_core.score.following import OLDEST
from improv_core.score.profiles import Profile, slow_speeds

REACTION = 0.1
"""Seconds from the decision that a robot must stand until its motors brake: zeros are sent and arrive, and its base
obeys them."""
BRAKING = 0.5
"""m/s² with which a robot brakes whose profile has no `max_linear_acceleration`: less than any built-in profile."""


def braking(profile: Profile) -> float:
    """Return the deceleration with which a robot brakes, in m/s²."""
    return profile.max_linear_acceleration or BRAKING


def coasting(speed: float, braking: float, age: float) -> float:
    """Return the most meters that a robot at this speed, in m/s, may be beyond its latest pose when it stands, if it
    gets the command now and that pose is so many seconds old."""
    return speed * (age + REACTION) + speed * speed / 2 / braking


def slow_coasting(profile: Profile) -> float:
    """Return the same for a robot that drives slowly to a place, with the oldest pose that counts."""
    return coasting(slow_speeds(profile)[0], braking(profile), OLDEST)
