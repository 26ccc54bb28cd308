"""The algebra of movement: a velocity over time, exact. `score/walk.py` walks it. Standard library only.

A movement lasts `duration` beats (an exact fraction, or `ENDLESS`) and has a velocity in the robot's own frame, in
steps per beat and quarter turns per beat. Nothing here costs time or memory in proportion to a repeat count.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple, TypeAlias

from improv_core.text import Span

ENDLESS = math.inf
Exact: TypeAlias = Fraction | int  # whole numbers are int: most are whole, and int is many times faster
Duration: TypeAlias = Fraction | int | float  # the only float is ENDLESS, and its type is the quickest way to tell
NORMAL = Fraction(1)
"""The rate of a movement without Pace. It is a Fraction, because dividing two ints gives a float."""


class Velocity(NamedTuple):
    """Forward, left, and up in steps per beat; yaw in quarter turns per beat, counterclockwise."""

    x: Exact = 0
    y: Exact = 0
    z: Exact = 0
    yaw: Exact = 0

    def plus(self, other: Velocity) -> Velocity:
        return Velocity(self.x + other.x, self.y + other.y, self.z + other.z, self.yaw + other.yaw)

    def times(self, other: Velocity) -> Velocity:
        """Each component times the same component of `other`. Most are zero and need no arithmetic."""
        if other is SAME:
            return self
        return Velocity(
            self.x and self.x * other.x,
            self.y and self.y * other.y,
            self.z and self.z * other.z,
            self.yaw and self.yaw * other.yaw,
        )


STILL = Velocity()
SAME = Velocity(1, 1, 1, 1)


def exact(number: Fraction) -> Exact:
    """The same number, as an int if it is whole."""
    return number if number.denominator != 1 else number.numerator


FINEST = 1_000_000
"""Positions in beats are rounded to this many parts of a beat."""


LARGEST = 10**100
"""The most beats, steps per beat, quarter turns per beat, and items per beat of a movement.

With any tempo and step, the product of any two of them stays below the largest float (1.8e308).
"""
MOST_BITS = 4096
"""The most bits of the exact fractions of a movement: nested odd factors multiply."""
MOST_VOICES = 250
"""How many voices may play at once, including those within names.

Each is walked by itself, and each level of voices within voices costs two of Python's levels of recursion.
"""


LONGEST_WRITTEN = 4096
"""The most bits of a number that is written in full: Python refuses to write integers of more than 4,300 digits."""


def near(beat: float) -> Exact:
    """A beat rounded to an exact number with few digits."""
    return exact(Fraction(round(beat * FINEST), FINEST))


def brief(number: Exact) -> Exact:
    """A number short enough to write: itself, or the nearest with a denominator up to `FINEST`.

    The statements of one robot may add up to fractions of any length.
    """
    return number if bits(number) <= LONGEST_WRITTEN else exact(Fraction(number).limit_denominator(FINEST))


def all_by(factor: Exact) -> Velocity:
    """The gain that multiplies every component by `factor`."""
    return Velocity(factor, factor, factor, factor)


class Peak(NamedTuple):
    """Bounds: the largest absolute components of the velocity, and the shortest item in beats."""

    x: float
    y: float
    z: float
    yaw: float
    shortest: float

    def times(self, gain: Velocity) -> Peak:
        x, y, z, yaw = (abs(float(factor)) for factor in gain)
        return _peak(self.x * x, self.y * y, self.z * z, self.yaw * yaw, self.shortest)

    def sped_up(self, rate: float) -> Peak:
        return _peak(self.x * rate, self.y * rate, self.z * rate, self.yaw * rate, self.shortest / rate)


_peak = lru_cache(maxsize=10_000)(Peak)  # thousands of movements share a few
_NO_PEAK = Peak(0.0, 0.0, 0.0, 0.0, math.inf)


@dataclass(frozen=True, slots=True, eq=False)
class Movement:
    """A movement. Made by the functions below, never directly.

    `uniform` is its velocity if that never changes. `width` is how many voices may play at once. `bits` is how many
    bits the factors around its moments may add to their fractions. `peak` bounds all of its moments.
    """

    duration: Duration
    uniform: Velocity | None
    width: int
    bits: int
    peak: Peak


@dataclass(frozen=True, slots=True, eq=False)
class Hold(Movement):
    velocity: Velocity
    span: Span | None


@dataclass(frozen=True, slots=True, eq=False)
class Series(Movement):
    items: tuple[Movement, ...]
    ends: tuple[Duration, ...]  # when each item ends


@dataclass(frozen=True, slots=True, eq=False)
class Parallel(Movement):
    voices: tuple[Movement, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Repeat(Movement):
    body: Movement
    times: int | None


@dataclass(frozen=True, slots=True, eq=False)
class Pace(Movement):
    body: Movement
    rate: Fraction


@dataclass(frozen=True, slots=True, eq=False)
class Gain(Movement):
    body: Movement
    gain: Velocity


@dataclass(frozen=True, slots=True, eq=False)
class Reverse(Movement):
    body: Movement


@dataclass(frozen=True, slots=True, eq=False)
class Use(Movement):
    body: Movement
    span: Span | None
    statement: int


def hold(velocity: Velocity, duration: Exact = 1, span: Span | None = None) -> Movement:
    """A constant velocity for `duration` beats, written at `span`."""
    x, y, z, yaw = (abs(float(value)) for value in velocity)
    return Hold(duration, velocity, 1, 0, _peak(x, y, z, yaw, float(duration)), velocity, span)


def series(items: Sequence[Movement]) -> Movement:
    """The items one after another. Items after an endless one are never reached."""
    if len(items) == 1:
        return items[0]
    end: Duration = 0
    ends = []
    width = bits = 0
    uniform: Velocity | None = None
    peak = _NO_PEAK
    peaks = set()
    for item in items:  # a single loop, because most of the work at a keystroke goes through here
        if item.duration:
            if not end:
                uniform = item.uniform
            elif uniform is not item.uniform and uniform != item.uniform:
                uniform = None
            end += item.duration
        ends.append(end)
        if item.peak is not peak:
            peak = item.peak
            peaks.add(peak)
        if item.width > width:
            width = item.width
        if item.bits > bits:
            bits = item.bits
    if len(peaks) > 1:
        peak = _bound(peaks, max)
    return Series(end, uniform, width, bits, peak, tuple(items), tuple(ends))


def _bound(peaks: Collection[Peak], together: Callable[[Sequence[float]], float]) -> Peak:
    """The combined peak of several movements: the maximum in series, the sum in parallel."""
    x, y, z, yaw, shortest = zip(*peaks, strict=True)
    return _peak(together(x), together(y), together(z), together(yaw), min(shortest))


def parallel(voices: Sequence[Movement]) -> Movement:
    """All voices at once: velocities add up, the shortest voice ends all, and empty voices are ignored."""
    voices = [voice for voice in voices if voice.duration]
    if len(voices) < 2:
        return series(voices)
    uniform: Velocity | None = STILL
    for voice in voices:
        uniform = uniform.plus(voice.uniform) if uniform and voice.uniform else None
    width = sum(voice.width for voice in voices)
    bits = max(voice.bits for voice in voices)
    peak = _bound([voice.peak for voice in voices], sum)
    return Parallel(min(voice.duration for voice in voices), uniform, width, bits, peak, tuple(voices))


def repeat(body: Movement, times: int | None = None) -> Movement:
    """The movement repeated `times` times, or forever if None. Repeating an empty movement gives an empty movement."""
    if not body.duration or times == 0:
        return series(())
    duration = ENDLESS if times is None else body.duration * times
    return Repeat(duration, body.uniform, body.width, body.bits, body.peak, body, times)


def pace(body: Movement, rate: Fraction) -> Movement:
    """The same path, `rate` times as fast."""
    if not body.duration:
        return body
    duration = ENDLESS if isinstance(body.duration, float) else body.duration / rate
    uniform = body.uniform and body.uniform.times(all_by(exact(rate)))
    return Pace(duration, uniform, body.width, body.bits + bits(rate), body.peak.sped_up(float(rate)), body, rate)


def gain(body: Movement, factors: Velocity) -> Movement:
    """The same duration, with each component of the velocity multiplied."""
    if not body.duration:
        return body
    uniform = body.uniform and body.uniform.times(factors)
    longer = max(bits(factor) for factor in factors)
    return Gain(body.duration, uniform, body.width, body.bits + longer, body.peak.times(factors), body, factors)


def reverse(body: Movement) -> Movement:
    """The same moments in reverse order. Raises ValueError if the movement is endless."""
    if isinstance(body.duration, float):
        raise ValueError("an endless movement has no end to start from")
    return Reverse(body.duration, body.uniform, body.width, body.bits, body.peak, body)


def use(body: Movement, span: Span | None, statement: int) -> Movement:
    """A movement written in the statement with this ID, used by a name at `span`."""
    return Use(body.duration, body.uniform, body.width, body.bits, body.peak, body, span, statement)


def is_too_fast(peak: Peak) -> bool:
    """Whether a bound is so large that floats can't hold what is computed from it."""
    x, y, z, yaw, shortest = peak
    return x > LARGEST or y > LARGEST or z > LARGEST or yaw > LARGEST or shortest < _SHORTEST


_SHORTEST = 1 / LARGEST


def bits(number: Exact) -> int:
    """The number of bits of an exact number, where 1 and -1 have none."""
    above, below = number.as_integer_ratio()  # one call, where `numerator` and `denominator` of a fraction are two
    return above.bit_length() + below.bit_length() - 2


def parts(movement: Movement) -> tuple[Movement, ...]:
    """The movements directly inside a movement."""
    if isinstance(movement, Series):
        return movement.items
    if isinstance(movement, Parallel):
        return movement.voices
    if isinstance(movement, (Repeat, Pace, Gain, Reverse, Use)):
        return (movement.body,)
    return ()
