"""The algebra of movement: a velocity over time, exact. `score/walk.py` walks it. Standard library only.

A movement lasts `duration` beats (an exact fraction, or `ENDLESS`) and has a velocity in the robot's own frame, in
steps per beat and quarter turns per beat. Nothing here costs time or memory in proportion to a repeat count.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from itertools import accumulate as count_up
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
"""How many voices may play at once, including those within names: each is walked by itself."""
MOST_DEPTH = 250
"""How deeply walks may be nested. Each level costs two of Python's levels of recursion."""
MOST_THROWS = 2**MOST_BITS
"""The most throws of one stream: their number is written into each throw's key."""


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


@dataclass(frozen=True, slots=True, eq=False)
class Bounds:
    """What bounds a movement. Thousands of movements share a few, so they are compared by identity.

    `peak` bounds all moments. `width` is how many voices may play at once. `bits` is how many bits the factors around
    its moments may add to their fractions. `depth` is how deeply walks are nested (in voices, ramps, and all that is
    open). `dice` tells whether a word of dice stands in it, even if it is never reached. `throws` is how many throws of
    its stream it takes. `open` tells whether senses decide what is performed (see `reactions`).
    """

    peak: Peak
    width: int
    bits: int
    depth: int
    dice: bool
    throws: int
    open: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Movement:
    """A movement. Made by functions here, in `ramps`, and in `dice`, never directly.

    `uniform` is its velocity if that never changes.
    """

    duration: Duration
    uniform: Velocity | None
    bounds: Bounds

    @property
    def peak(self) -> Peak:
        return self.bounds.peak

    @property
    def width(self) -> int:
        return self.bounds.width

    @property
    def bits(self) -> int:
        return self.bounds.bits

    @property
    def depth(self) -> int:
        return self.bounds.depth

    @property
    def dice(self) -> bool:
        return self.bounds.dice

    @property
    def throws(self) -> int:
        return self.bounds.throws

    @property
    def open(self) -> bool:
        return self.bounds.open


@dataclass(frozen=True, slots=True, eq=False)
class Single(Movement):
    """A movement made of one other movement."""

    body: Movement


@dataclass(frozen=True, slots=True, eq=False)
class Several(Movement):
    """A movement made of several others."""

    items: tuple[Movement, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Hold(Movement):
    velocity: Velocity
    span: Span | None


@dataclass(frozen=True, slots=True, eq=False)
class Series(Several):
    ends: tuple[Duration, ...]  # when each item ends
    first_throws: tuple[int, ...]  # the throw at which each item begins, counted from the first; empty without dice


@dataclass(frozen=True, slots=True, eq=False)
class Parallel(Several):
    """Voices. With dice, an empty voice stays among them, because each throws from the stream of its index."""


@dataclass(frozen=True, slots=True, eq=False)
class Repeat(Single):
    times: int | None


@dataclass(frozen=True, slots=True, eq=False)
class Pace(Single):
    rate: Fraction


@dataclass(frozen=True, slots=True, eq=False)
class Gain(Single):
    gain: Velocity


@dataclass(frozen=True, slots=True, eq=False)
class Reverse(Single):
    pass


@dataclass(frozen=True, slots=True, eq=False)
class Use(Single):
    span: Span | None
    statement: int


def hold(velocity: Velocity, duration: Exact = 1, span: Span | None = None) -> Movement:
    """A constant velocity for `duration` beats, written at `span`."""
    x, y, z, yaw = (abs(float(value)) for value in velocity)
    return Hold(duration, velocity, _held(x, y, z, yaw, float(duration)), velocity, span)


def stand(duration: Exact) -> Movement:
    """Standing still for `duration` beats, or not at all. It is not written anywhere, so it never counts as an item
    that is too short."""
    return Hold(duration, STILL, UNBOUNDED, STILL, None) if duration else series(())


def series(items: Sequence[Movement]) -> Movement:
    """The items one after another. Items after an endless one are never reached."""
    if len(items) == 1:
        return items[0]
    end: Duration = 0
    ends = []
    uniform: Velocity | None = None
    bounds = items[0].bounds if items else UNBOUNDED
    for item in items:  # a single loop, because most of the work at a keystroke goes through here
        if item.duration:
            if not end:
                uniform = item.uniform
            elif uniform is not item.uniform and uniform != item.uniform:
                uniform = None
            end += item.duration
        ends.append(end)
        if item.bounds is not bounds:
            bounds = _either(bounds, item.bounds)
    if bounds.open:
        bounds = opened(bounds)
    first_throws: tuple[int, ...] = ()
    if bounds.dice:
        *reached, throws = count_up((item.throws for item in items), initial=0)
        bounds, first_throws = replace(bounds, throws=throws), tuple(reached)
    return Series(end, uniform, bounds, tuple(items), tuple(ends), first_throws)


def parallel(voices: Sequence[Movement]) -> Movement:
    """All voices at once: velocities add up, the shortest voice ends all, and empty voices are ignored."""
    playing = [voice for voice in voices if voice.duration or voice.open]
    dice = len(voices) > 1 and any(voice.bounds.dice for voice in voices)
    if not dice and len(playing) < 2:
        return series(playing)
    uniform: Velocity | None = STILL if playing else None
    for voice in playing:
        uniform = uniform.plus(voice.uniform) if uniform and voice.uniform else None
    bounds = _in_parallel(tuple(voice.bounds for voice in playing), dice)
    duration = min((voice.duration for voice in playing if voice.duration), default=0)
    return Parallel(duration, uniform, bounds, tuple(voices if dice else playing))


def repeat(body: Movement, times: int | None = None) -> Movement:
    """The movement repeated `times` times, or forever if None. Repeating an empty movement gives an empty movement."""
    if times == 0 or not (body.duration or body.open):
        if not body.bounds.dice:
            return series(())
        duration: Duration = 0
    else:
        duration = ENDLESS if times is None else body.duration * times
    uniform = body.uniform if body.duration else STILL  # turns that take no time are followed by standing still
    bounds = opened(body.bounds) if body.bounds.open else body.bounds
    if bounds.dice:
        bounds = replace(bounds, throws=1 if times is None else bounds.throws * times)
    return Repeat(duration, uniform, bounds, body, times)


def pace(body: Movement, rate: Fraction) -> Movement:
    """The same path, `rate` times as fast."""
    if not (body.duration or body.open):
        return body
    duration = ENDLESS if isinstance(body.duration, float) else exact(body.duration / rate)
    uniform = body.uniform and body.uniform.times(all_by(exact(rate)))
    return Pace(duration, uniform, _sped_up(body.bounds, rate), body, rate)


def fit(body: Movement, beats: Exact) -> Movement:
    """The same path in exactly `beats` beats. Raises ValueError if the movement is endless or open."""
    require_end(body)
    assert not isinstance(body.duration, float)
    return pace(body, Fraction(body.duration) / beats)


def gain(body: Movement, factors: Velocity) -> Movement:
    """The same duration, with each component of the velocity multiplied."""
    if not (body.duration or body.open):
        return body
    uniform = body.uniform and body.uniform.times(factors)
    return Gain(body.duration, uniform, _amplified(body.bounds, factors), body, factors)


def reverse(body: Movement) -> Movement:
    """The same moments in reverse order. Raises ValueError if the movement is endless or open."""
    require_end(body)
    return Reverse(body.duration, body.uniform, body.bounds, body)


def require_end(body: Movement) -> None:
    """Raise ValueError if a movement is endless, or if senses decide when it ends."""
    if isinstance(body.duration, float) or body.open:
        raise ValueError("a movement that is endless or open has no end that is known")


def accumulate(items: Sequence[Movement]) -> Movement:
    """Of items a, b, c: a, then a b, then a b c. Each beginning is shared by all that are longer."""
    return series(list(count_up(items, lambda beginning, item: series((beginning, item)))))


def use(body: Movement, span: Span | None, statement: int) -> Movement:
    """A movement written in the statement with this ID, used by a name at `span`."""
    return Use(body.duration, body.uniform, body.bounds, body, span, statement)


_peak = lru_cache(maxsize=10_000)(Peak)
_bounds = lru_cache(maxsize=10_000)(Bounds)  # a program has far fewer different bounds than movements
UNBOUNDED = Bounds(Peak(0.0, 0.0, 0.0, 0.0, math.inf), 0, 0, 0, False, 0)
"""The bounds of nothing."""


@lru_cache(maxsize=10_000)
def _held(x: float, y: float, z: float, yaw: float, shortest: float) -> Bounds:
    return Bounds(_peak(x, y, z, yaw, shortest), 1, 0, 0, False, 0)


def in_series(kinds: Iterable[Bounds]) -> Bounds:
    """The bounds, except the throws, of movements that play one after another, or of which only one plays."""
    bounds = UNBOUNDED
    for each in kinds:
        bounds = _either(bounds, each)
    return bounds


@lru_cache(maxsize=10_000)
def _either(one: Bounds, other: Bounds) -> Bounds:
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
def _in_parallel(voices: tuple[Bounds, ...], dice: bool) -> Bounds:
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
def _sped_up(bounds: Bounds, rate: Fraction) -> Bounds:
    peak, longer = faster(bounds.peak, float(rate)), bounds.bits + bits(rate)
    return _bounds(peak, bounds.width, longer, bounds.depth, bounds.dice, bounds.throws, bounds.open)


def faster(peak: Peak, rate: float) -> Peak:
    """The peak of a movement that is played `rate` times as fast."""
    return _peak(peak.x * rate, peak.y * rate, peak.z * rate, peak.yaw * rate, peak.shortest / rate)


@lru_cache(maxsize=10_000)
def _amplified(bounds: Bounds, factors: Velocity) -> Bounds:
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


def bits(number: Exact) -> int:
    """The number of bits of an exact number, where 1 and -1 have none."""
    above, below = number.as_integer_ratio()  # one call, where `numerator` and `denominator` of a fraction are two
    return above.bit_length() + below.bit_length() - 2


def parts(movement: Movement) -> tuple[Movement, ...]:
    """The movements directly inside a movement."""
    if isinstance(movement, Several):
        return movement.items
    return (movement.body,) if isinstance(movement, Single) else ()
