"""The bounds of movements that are made of others. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache

from improv_core.score.measured import Bound, Measure, larger, largest, units_in
from improv_core.score.movement import (
    DIRECTIONS,
    LARGEST,
    NO_BODY_WORDS,
    Asked,
    BodyWords,
    Bounds,
    Exact,
    Factors,
    Peak,
    bits,
)
from improv_core.values import Shared

_PEAKS = Shared(Peak, 10_000)
_bounds = lru_cache(maxsize=10_000)(Bounds)  # a program has far fewer different bounds than movements
UNBOUNDED = Bounds(Peak(0.0, 0.0, 0.0, 0.0, math.inf), 0, 0, 0, False, 0)
"""The bounds of an empty movement."""
MAX_FACTOR, MIN_FACTOR = Fraction(10**300), Fraction(1, 10**300)


@lru_cache(maxsize=10_000)
def held(x: Bound, y: Bound, z: Bound, yaw: Bound, shortest: float, longest: int = 0) -> Bounds:
    """Return the bounds of one velocity. `longest` is the number of bits of its numbers, if they are measured."""
    return Bounds(_PEAKS[x, y, z, yaw, shortest], 1, longest, 0, False, 0)


def in_series(kinds: Iterable[Bounds]) -> Bounds:
    """Return the bounds, except the throws, of movements that play one after another, or of which only one plays."""
    bounds = UNBOUNDED
    for each in kinds:
        bounds = either(bounds, each)
    return bounds


@lru_cache(maxsize=2_000)  # more cost 3 MB in a program of 10,000 lines, and save 2,000 calls
def either(one: Bounds, other: Bounds) -> Bounds:
    return _bounds(
        _either_peak(one.peak, other.peak),
        max(one.width, other.width),
        max(one.bits, other.bits),
        max(one.depth, other.depth),
        one.dice or other.dice,
        0,
        one.open or other.open,
        _either_words(one.body, other.body),
    )


def _either_peak(one: Peak, other: Peak) -> Peak:
    if one is other:
        return one
    return _PEAKS[
        larger(one.x, other.x),
        larger(one.y, other.y),
        larger(one.z, other.z),
        larger(one.yaw, other.yaw),
        min(one.shortest, other.shortest),
    ]


def _either_words(one: BodyWords, other: BodyWords) -> BodyWords:
    if not (one.asked or other.asked):
        return NO_BODY_WORDS
    return BodyWords(one.asked | other.asked, _either_peak(one.peak, other.peak))


@lru_cache(maxsize=10_000)
def opened(bounds: Bounds) -> Bounds:
    """Return the bounds of an open movement around this one: its performance contains another one."""
    return replace(bounds, open=True, depth=bounds.depth + 1)


@lru_cache(maxsize=10_000)
def in_parallel(voices: tuple[Bounds, ...], dice: bool) -> Bounds:
    if not voices:
        return replace(UNBOUNDED, dice=dice, throws=1)
    return _bounds(
        _peak_of_all([each.peak for each in voices]),
        sum(each.width for each in voices),
        max(each.bits for each in voices),
        max(each.depth for each in voices) + 1,
        dice,
        int(dice),
        any(each.open for each in voices),
        _words_of_all([each.body for each in voices]),
    )


def _peak_of_all(voices: Sequence[Peak]) -> Peak:
    x, y, z, yaw, shortest = zip(*voices, strict=True)
    return _PEAKS[sum(x), sum(y), sum(z), sum(yaw), min(shortest)]


def _words_of_all(voices: Sequence[BodyWords]) -> BodyWords:
    asked = frozenset[Asked]().union(*(each.asked for each in voices))
    return BodyWords(asked, _peak_of_all([each.peak for each in voices])) if asked else NO_BODY_WORDS


@lru_cache(maxsize=10_000)
def sped_up(bounds: Bounds, above: int, below: int) -> Bounds:
    """Return the bounds of a movement at this rate: two ints are hashed faster than their fraction."""
    rate = Fraction(above, below)
    peak, longer = faster(bounds.peak, rate), bounds.bits + bits(rate)
    words = words_faster(bounds.body, rate)
    return _bounds(peak, bounds.width, longer, bounds.depth, bounds.dice, bounds.throws, bounds.open, words)


def _near(factor: Exact) -> float:
    """Return a positive factor as a float. A factor beyond the range of floats becomes nearly as large or as small as
    they get: it is refused later, for its bounds."""
    if MIN_FACTOR <= factor <= MAX_FACTOR:
        return float(factor)
    return float(MAX_FACTOR if factor > 1 else MIN_FACTOR)


def faster(peak: Peak, rate: Exact) -> Peak:
    """Return the peak of a movement that is played `rate` times as fast."""
    times = _near(rate)
    return _PEAKS[peak.x * times, peak.y * times, peak.z * times, peak.yaw * times, peak.shortest / times]


def words_faster(words: BodyWords, rate: Exact) -> BodyWords:
    """Return the words for body parts, played `rate` times as fast."""
    return words._replace(peak=faster(words.peak, rate)) if words.asked else words


@lru_cache(maxsize=10_000)
def amplified(bounds: Bounds, factors: Factors) -> Bounds:
    peak = _times(bounds.peak, factors)
    longer = bounds.bits + max(bits(factor) for factor in factors)
    words = bounds.body
    if words.asked:
        asked = frozenset(map(_exchanged, words.asked)) if swaps_sides(factors) else words.asked
        words = BodyWords(asked, _times(words.peak, factors))
    return _bounds(peak, bounds.width, longer, bounds.depth, bounds.dice, bounds.throws, bounds.open, words)


def _times(peak: Peak, factors: Factors) -> Peak:
    x, y, z, yaw = (_near(max(factor, -factor)) if factor else 0.0 for factor in factors)
    return _PEAKS[peak.x * x, peak.y * y, peak.z * z, peak.yaw * yaw, peak.shortest]


def _exchanged(asked: Asked) -> Asked:
    return asked._replace(mirrored=not asked.mirrored) if asked.part else asked


def swaps_sides(gain: Factors) -> bool:
    """Return whether a gain is that of `reflect YZ`."""
    return gain.y < 0 < gain.x


@lru_cache(maxsize=10_000)
def under_part(bounds: Bounds, part: str) -> Bounds:
    """Return the bounds of a movement that a body part performs: the base stands."""
    peak, words = bounds.peak, bounds.body
    own = {Asked(part, False, each) for each in DIRECTIONS if getattr(peak, each)}
    own |= {Asked(part, False, each, unit=unit) for each in DIRECTIONS for unit in units_in(getattr(peak, each))}
    inner = {each if each.part else each._replace(part=part) for each in words.asked}
    performed = BodyWords(frozenset({Asked(part), *own, *inner}), _either_peak(peak, words.peak))
    still = _PEAKS[0.0, 0.0, 0.0, 0.0, peak.shortest]
    return replace(bounds, peak=still, body=performed)


@lru_cache(maxsize=10_000)
def is_measured(bounds: Bounds) -> bool:
    """Return whether a program measures velocities of the base, or of body parts."""
    return any(isinstance(each, Measure) for peak in (bounds.peak, bounds.body.peak) for each in peak)


def is_too_fast(peak: Peak) -> bool:
    """Return whether a bound is so large that floats can't hold the results computed from it."""
    return any(largest(each) > LARGEST for each in peak[:4]) or peak.shortest < _SHORTEST


_SHORTEST = 1 / LARGEST
