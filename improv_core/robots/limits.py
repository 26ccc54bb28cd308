"""Speeds at which robots should move, their limits, and changes that make a speed fit. All decisions are exact."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import islice

from improv_core.score.measured import DEGREE, in_si
from improv_core.score.movement import NOTHING_AROUND, Movement, Peak, Piecewise, Velocity
from improv_core.score.profiles import MOTIONS, Profile
from improv_core.score.score import in_axes
from improv_core.score.suppositions import with_all_sides
from improv_core.score.traversal import inner_first
from improv_core.score.walk import walk


@dataclass(frozen=True, slots=True)
class Speeds:
    """Speeds in any direction: `linear` in m/s, `angular` in rad/s."""

    linear: float
    angular: float


@dataclass(frozen=True, slots=True)
class Fitting:
    """Changes that make a movement fit: `tempo` is the largest whole tempo at which it fits (None if below 1), and
    `slow` the smallest whole factor for `slow` at the current tempo."""

    tempo: int | None
    slow: int

    def advice(self) -> str:
        """Return a sentence such as: use `beat 41`, or `slow 2 ( … )` around the whole movement"""
        tempo = f"`beat {self.tempo}`, or " if self.tempo else ""
        return f"use {tempo}`slow {self.slow} ( … )` around the whole movement"


@dataclass(frozen=True, slots=True)
class Excess(Fitting):
    """Amount by which a velocity exceeds a robot's limits, and the changes that make it fit.

    `speed` and `limit` are those that it exceeds most, in their `unit`, m/s or rad/s; `factor` is their ratio.
    """

    unit: str
    speed: float
    limit: float
    factor: float


def speed(velocity: Velocity, profile: Profile, tempo: Fraction) -> Speeds:
    """Return the speed of a robot with this profile at `tempo` beats per minute."""
    linear, angular = _squares(velocity, profile, tempo)
    return Speeds(_root(linear), _root(angular))


def top_speed(movement: Movement, profile: Profile, tempo: Fraction, most: int) -> Speeds | None:
    """Return the largest speeds in a movement; None if it has voices or ramps with more moments than `most`.

    Everything that dice and senses may choose counts. As in `path.extent`, each part is visited once, no matter how
    often it repeats.
    """
    movement = with_all_sides(movement)
    known: dict[int, Speeds | None] = {}
    for part in inner_first(movement, _inside):
        known[id(part)] = _top_speed(part, [known[id(each)] for each in _inside(part)], profile, tempo, most)
    return known[id(movement)]


def _inside(part: Movement) -> tuple[Movement, ...]:
    """Return the parts whose speeds decide that of a movement; none if its own velocities do."""
    return () if part.uniform is not None or isinstance(part, Piecewise) else part.parts


def _top_speed(
    part: Movement, inner: Sequence[Speeds | None], profile: Profile, tempo: Fraction, most: int
) -> Speeds | None:
    if part.uniform is not None:
        return speed(part.uniform, profile, tempo)
    if isinstance(part, Piecewise):
        moments = list(islice(walk(part, merge=True), most + 1))
        inner = [speed(moment.velocity, profile, tempo) for moment in moments] if len(moments) <= most else [None]
    speeds = [each for each in inner if each]
    if len(speeds) < len(inner):
        return None
    linear = max((each.linear for each in speeds), default=0.0)
    angular = max((each.angular for each in speeds), default=0.0)
    around = part.within(NOTHING_AROUND)
    rate, gain = float(around.rate), around.gain
    return Speeds(linear * rate * float(abs(gain.x)), angular * rate * float(abs(gain.yaw)))


def excess(velocity: Velocity, profile: Profile, tempo: Fraction) -> Excess | None:
    """Return the excess of a velocity over the profile's limits at `tempo` beats per minute; None if there is none."""
    linear, angular = _squares(velocity, profile, tempo)
    over = [
        (square / _as_written(limit) ** 2, unit, square, limit)
        for unit, square, limit in (("m/s", linear, profile.max_linear), ("rad/s", angular, profile.max_angular))
        if limit is not None
    ]
    nothing = (Fraction(0), "", Fraction(0), 0.0)
    ratio, unit, square, limit = max(over, key=lambda each: each[0], default=nothing)
    if ratio <= 1:
        return None
    fitting = math.isqrt(math.floor(tempo * tempo / ratio))  # whole n with n² <= tempo² / ratio
    return Excess(fitting or None, _root_up(ratio), unit, _root(square), limit, _root(ratio))


@dataclass(frozen=True, slots=True)
class Rush(Fitting):
    """A change of velocity that `lasts` for fewer seconds than it `needs`, and the changes that make it fit."""

    needs: float
    lasts: float

    @property
    def shortage(self) -> float:
        return self.needs / self.lasts


def rush(needs: float, lasts: float, tempo: Fraction) -> Rush | None:
    """Return whether a change of velocity that needs these seconds has too few, at `tempo` beats per minute.

    Played k times as slowly, it is k times as small, and there is k times as much time for it.
    """
    if needs <= lasts * _SLACK:
        return None
    fitting = fitting_by(math.sqrt(needs / lasts), tempo)
    return Rush(fitting.tempo, fitting.slow, needs, lasts)


def fitting_by(factor: float, tempo: Fraction) -> Fitting:
    """Return what makes a movement fit that would have to be `factor` times as slow."""
    factor /= _SLACK
    return Fitting(math.floor(float(tempo) / factor) or None, math.ceil(factor))


def unsupported(velocity: Velocity | Peak, profile: Profile) -> tuple[str, ...]:
    """Return the motions of a velocity that a robot with this profile can't make, in the order of `MOTIONS`."""
    asked = zip(MOTIONS, (velocity.x, velocity.yaw, velocity.y, velocity.z), strict=True)
    return tuple(motion for motion, value in asked if value and motion not in profile.motions)


def too_tight(velocity: Velocity, profile: Profile) -> float | None:
    """Return the radius in meters of a curve that is tighter than a car with this profile can drive; None if it can."""
    if profile.turning_radius is None or not velocity.yaw:
        return None
    x, _, _, yaw = in_axes(velocity, profile)
    if not yaw:
        return None
    radius = abs(x) / abs(yaw)
    return radius if radius * _SLACK < profile.turning_radius else None


_SLACK = 1 + 1e-9
"""A quarter turn is no exact number of radians: rounding must not make a curve too tight."""


def _squares(velocity: Velocity, profile: Profile, tempo: Fraction) -> tuple[Fraction, Fraction]:
    """Return the squares of both speeds. Unlike the length of a vector, they are exact."""
    linear, angular = (_as_written(scale) * tempo / 60 for scale in (profile.linear_scale, profile.angular_scale))
    x, y, z, yaw = exactly(velocity, profile)
    return (x**2 + y**2 + z**2) * linear**2, (yaw * angular) ** 2


def exactly(velocity: Velocity, profile: Profile) -> list[Fraction]:
    """Return a velocity in meters and radians per beat, exactly as the profile has it: 2 m and a step may be equal."""
    step, turn = _as_written(profile.step), _as_written(profile.quarter_turn)
    degree = turn / 90 if profile.quarter_turn == math.pi / 2 else _as_written(DEGREE)
    own = (step, step, step, turn)
    return [in_si(each, one, turn, degree) for each, one in zip(velocity, own, strict=True)]


@lru_cache(maxsize=100)
def _as_written(number: float) -> Fraction:
    """Convert to a fraction: 0.2 as people mean it, not in binary, so a speed exactly at the limit is allowed."""
    return Fraction(repr(number))


def _root(square: Fraction) -> float:
    """Return the square root as a float; infinity if it is too large for one."""
    try:
        return math.sqrt(square)
    except OverflowError:
        return math.inf


def _root_up(square: Fraction) -> int:
    """Return the smallest whole number whose square is at least `square`, which must be above 0."""
    return math.isqrt(math.ceil(square) - 1) + 1
