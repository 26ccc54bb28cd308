"""A robot's setpoints: every change of velocity at its exact time, then zeros."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import NamedTuple

from improv_core.safety.pending_zeros import LAST_ZEROS
from improv_core.score.motion import STILL, Twist
from improv_core.score.movement import Exact, Movement
from improv_core.score.profiles import Profile
from improv_core.score.score import twist
from improv_core.score.walk import walk

SHORTEST = Fraction(1, 1000)
"""Seconds. Faster changes are sampled at this interval, so no program can flood a robot. Only a seek may lead closer to
the next change."""

Velocity = Twist | Mapping[str, float]
"""The velocity of a base, or of the joints of a body part, by name, in rad/s or m/s. A zero twist stops either."""


class Setpoint(NamedTuple):
    """A velocity of a base or a body part from `at` seconds on. If it is `held`, it is repeated until the next one."""

    at: float
    velocity: Velocity
    held: bool


def setpoints(profile: Profile, movement: Movement, tempo: Fraction, start: Exact = 0) -> Iterator[Setpoint]:
    """Yield the setpoints of a movement from its beat `start` on, with times from there: each change, then zeros."""
    period = 1 / profile.command_rate
    seconds = 60 / tempo
    shortest = SHORTEST / seconds
    duration = movement.duration
    if start >= duration:
        yield from zeros(0.0, period)
        return
    moments = walk(movement, start, merge=True)
    while moment := next(moments, None):
        if moment.duration < shortest and (moment.start > start or not start):
            end = moment.start + shortest
            if end >= duration:
                end = Fraction(duration)
            moments = walk(movement, end, merge=True)
        # Compute each time from the start instead of adding up, so no error grows however long it plays.
        yield Setpoint(float((moment.start - start) * seconds), twist(moment.velocity, profile, tempo), True)
    yield from zeros(float((duration - start) * seconds), period)


def zeros(start: float, period: float) -> Iterator[Setpoint]:
    """Return the short burst of zeros that stops a robot."""
    return (Setpoint(start + count * period, STILL, False) for count in range(LAST_ZEROS))
