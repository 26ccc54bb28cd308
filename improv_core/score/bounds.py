"""The bounds of movements that are made of others. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

from improv_core.score.movement import LARGEST, Bounds, Peak, Velocity, bits

_peak = lru_cache(maxsize=10_000)(Peak)
_bounds = lru_cache(maxsize=10_000)(Bounds)  # a program has far fewer different bounds than movements
UNBOUNDED = Bounds(Peak(0.0, 0.0, 0.0, 0.0, math.inf), 0, 0, 0, False, 0)
"""The bounds of nothing."""


@lru_cache(maxsize=10_000)
def held(x: float, y: float, z: float, yaw: float, shortest: float) -> Bounds:
    return Bounds(_peak(x, y, z, yaw, shortest), 1, 0, 0, False, 0)


def in_series(kinds: Iterable[Bounds]) -> Bounds:
    """The bounds, except the throws, of movements that play one after another, or of which only one plays."""
    bounds = UNBOUNDED
    for each in kinds:
        bounds = either(bounds, each)
    return bounds


@lru_cache(maxsize=10_000)
def either(one: Bounds, other: Bounds) -> Bounds:
    mine, others = one.peak, other.peak
    return _bounds(
        _peak(
            max(mine.x, others.x),
            max(mine.y, others.y),
            max(mine.z, others.z),
            max(mine.yaw, others.yaw),
            min(mine.shortest, others.shortest),
        ),
        max(one.width, other.width),
        max(one.bits, other.bits),
        max(one.depth, other.depth),
        one.dice or other.dice,
        0,
        one.open or other.open,
    )


@lru_cache(maxsize=10_000)
def opened(bounds: Bounds) -> Bounds:
    """The bounds of an open movement around this one: its performance contains another one."""
    return replace(bounds, open=True, depth=bounds.depth + 1)


@lru_cache(maxsize=10_000)
def in_parallel(voices: tuple[Bounds, ...], dice: bool) -> Bounds:
    if not voices:
        return replace(UNBOUNDED, dice=dice, throws=1)
    x, y, z, yaw, shortest = zip(*(each.peak for each in voices), strict=True)
    return _bounds(
        _peak(sum(x), sum(y), sum(z), sum(yaw), min(shortest)),
        sum(each.width for each in voices),
        max(each.bits for each in voices),
        max(each.depth for each in voices) + 1,
        dice,
        int(dice),
        any(each.open for each in voices),
    )


@lru_cache(maxsize=10_000)
def sped_up(bounds: Bounds, rate: Fraction) -> Bounds:
    peak, longer = faster(bounds.peak, float(rate)), bounds.bits + bits(rate)
    return _bounds(peak, bounds.width, longer, bounds.depth, bounds.dice, bounds.throws, bounds.open)


def faster(peak: Peak, rate: float) -> Peak:
    """The peak of a movement that is played `rate` times as fast."""
    return _peak(peak.x * rate, peak.y * rate, peak.z * rate, peak.yaw * rate, peak.shortest / rate)


@lru_cache(maxsize=10_000)
def amplified(bounds: Bounds, factors: Velocity) -> Bounds:
    x, y, z, yaw = (abs(float(factor)) for factor in factors)
    peak = bounds.peak
    amplified = _peak(peak.x * x, peak.y * y, peak.z * z, peak.yaw * yaw, peak.shortest)
    longer = bounds.bits + max(bits(factor) for factor in factors)
    return _bounds(amplified, bounds.width, longer, bounds.depth, bounds.dice, bounds.throws, bounds.open)


def is_too_fast(peak: Peak) -> bool:
    """Whether a bound is so large that floats can't hold what is computed from it."""
    x, y, z, yaw, shortest = peak
    return x > LARGEST or y > LARGEST or z > LARGEST or yaw > LARGEST or shortest < _SHORTEST


_SHORTEST = 1 / LARGEST
