"""The algebra of movement: a velocity over time, exact, and walked lazily. Standard library only.

A movement lasts `duration` beats (an exact fraction, or `ENDLESS`) and has a velocity in the robot's own frame, in
steps per beat and quarter turns per beat. Nothing here costs time or memory in proportion to a repeat count.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import count
from typing import NamedTuple, TypeAlias

from improv_core.text import Span

ENDLESS = math.inf
Exact: TypeAlias = Fraction | int  # whole numbers come as int where they can: most are, and it is many times faster
Duration: TypeAlias = Fraction | int | float  # the only float is ENDLESS
NORMAL = Fraction(1)
"""The rate of what is not paced. A fraction: two integers would divide to a float."""


class Velocity(NamedTuple):
    """Forward, leftward and upward steps per beat; counter-clockwise quarter turns per beat."""

    x: Exact = 0
    y: Exact = 0
    z: Exact = 0
    yaw: Exact = 0

    def plus(self, other: Velocity) -> Velocity:
        return Velocity(self.x + other.x, self.y + other.y, self.z + other.z, self.yaw + other.yaw)

    def times(self, other: Velocity) -> Velocity:
        """Each component times the same component of `other`. Most are zero, and need no arithmetic."""
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
    """The same number, as an int where it is whole."""
    return number if number.denominator != 1 else number.numerator


FINEST = 1_000_000
"""Parts of a beat at which playing, or what tells of it, may begin."""


LARGEST = 10**100
"""Beats, steps per beat, quarter turns per beat and items per beat that a movement may have.

With any tempo and step, the product of any two of them stays below the largest float (1.8e308).
"""
MOST_BITS = 4096
"""How long the exact fractions of a movement may get: nested odd factors multiply."""
DEEPEST_VOICES = 200
"""How many levels of `||` may nest through names: each costs a level of recursion when walked."""


LONGEST_WRITTEN = 4096
"""Bits of a number that is written out: Python writes no integer beyond 4,300 digits."""


def near(beat: float) -> Exact:
    """A beat as an exact number that is not long."""
    return exact(Fraction(round(beat * FINEST), FINEST))


def brief(number: Exact) -> Exact:
    """A number short enough to be written: itself, or the nearest of those with a denominator up to `FINEST`.

    The parts of all statements of a robot add up to fractions of any length.
    """
    return number if bits(number) <= LONGEST_WRITTEN else exact(Fraction(number).limit_denominator(FINEST))


def all_by(factor: Exact) -> Velocity:
    """The gain that multiplies every component by `factor`."""
    return Velocity(factor, factor, factor, factor)


class Place(NamedTuple):
    """A span that counts from the start of the statement it is written in, and that statement's number.

    Movements are kept while statements before them grow and shrink; so they know no offsets in the document.
    """

    statement: int
    span: Span


class Moment(NamedTuple):
    """A stretch of constant velocity: start and duration in beats, and the words that are playing in it."""

    start: Exact
    duration: Exact
    velocity: Velocity
    places: tuple[Place, ...]


class Peak(NamedTuple):
    """Bounds: the components of the velocity are at most so large, and no item is shorter than so many beats."""

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

    `uniform` is its velocity where that never changes; `depth` is how many levels of voices stand within voices;
    `bits` is how long the fractions of its moments may get from the factors around them; `peak` is what none of its
    moments exceeds.
    """

    duration: Duration
    uniform: Velocity | None
    depth: int
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
    """One velocity for `duration` beats, written at `span`."""
    x, y, z, yaw = (abs(float(value)) for value in velocity)
    return Hold(duration, velocity, 0, 0, _peak(x, y, z, yaw, float(duration)), velocity, span)


def series(items: Sequence[Movement]) -> Movement:
    """One after the other; what follows an endless item is never reached."""
    if len(items) == 1:
        return items[0]
    end: Duration = 0
    ends = []
    depth = bits = 0
    velocities = set()
    peaks = set()
    for item in items:  # one loop: most of what is understood at a keystroke passes here
        if item.duration:
            end += item.duration
            velocities.add(item.uniform)
        ends.append(end)
        peaks.add(item.peak)
        if item.depth > depth:
            depth = item.depth
        if item.bits > bits:
            bits = item.bits
    uniform = velocities.pop() if len(velocities) == 1 else None
    peak = peaks.pop() if len(peaks) == 1 else _bound(peaks, max)
    return Series(end, uniform, depth, bits, peak, tuple(items), tuple(ends))


def _bound(peaks: Collection[Peak], together: Callable[[Sequence[float]], float]) -> Peak:
    """The peak of what is made of several: the highest of them in series, their sum in parallel."""
    if not peaks:
        return _NO_PEAK
    x, y, z, yaw, shortest = zip(*peaks, strict=True)
    return _peak(together(x), together(y), together(z), together(yaw), min(shortest))


def parallel(voices: Sequence[Movement]) -> Movement:
    """All at once, velocities added, cut where the shortest ends; empty voices are ignored."""
    voices = [voice for voice in voices if voice.duration]
    if len(voices) < 2:
        return series(voices)
    uniform: Velocity | None = STILL
    for voice in voices:
        uniform = uniform.plus(voice.uniform) if uniform and voice.uniform else None
    depth = 1 + max(voice.depth for voice in voices)
    bits = max(voice.bits for voice in voices)
    peak = _bound([voice.peak for voice in voices], sum)
    return Parallel(min(voice.duration for voice in voices), uniform, depth, bits, peak, tuple(voices))


def repeat(body: Movement, times: int | None = None) -> Movement:
    """So many times, or forever. Repeating what takes no time takes no time."""
    if not body.duration or times == 0:
        return series(())
    duration = ENDLESS if times is None else body.duration * times
    return Repeat(duration, body.uniform, body.depth, body.bits, body.peak, body, times)


def pace(body: Movement, rate: Fraction) -> Movement:
    """The same path, `rate` times as fast."""
    if not body.duration:
        return body
    duration = body.duration / rate if body.duration != ENDLESS else ENDLESS
    uniform = body.uniform and body.uniform.times(all_by(exact(rate)))
    return Pace(duration, uniform, body.depth, body.bits + bits(rate), body.peak.sped_up(float(rate)), body, rate)


def gain(body: Movement, factors: Velocity) -> Movement:
    """The same time, each component of the velocity multiplied."""
    if not body.duration:
        return body
    uniform = body.uniform and body.uniform.times(factors)
    longer = max(bits(factor) for factor in factors)
    return Gain(body.duration, uniform, body.depth, body.bits + longer, body.peak.times(factors), body, factors)


def reverse(body: Movement) -> Movement:
    """What is performed, in reverse order. Raises ValueError if it is endless."""
    if body.duration == ENDLESS:
        raise ValueError("an endless movement has no end to start from")
    return Reverse(body.duration, body.uniform, body.depth, body.bits, body.peak, body)


def use(body: Movement, span: Span | None, statement: int) -> Movement:
    """A movement that is written in another statement, by that one's number; the name for it stands at `span`."""
    return Use(body.duration, body.uniform, body.depth, body.bits, body.peak, body, span, statement)


def is_too_fast(peak: Peak) -> bool:
    """Whether a bound is so large that floats can't hold what is computed from it."""
    x, y, z, yaw, shortest = peak
    return x > LARGEST or y > LARGEST or z > LARGEST or yaw > LARGEST or shortest < _SHORTEST


_SHORTEST = 1 / LARGEST


def bits(number: Exact) -> int:
    """How long an exact number is; 1 and -1 count as nothing."""
    return abs(number.numerator).bit_length() + number.denominator.bit_length() - 2


def walk(movement: Movement, start: Exact = 0, *, merge: bool = False) -> Iterator[Moment]:
    """The moments of a movement from beat `start` on, in order, without gaps, each longer than zero.

    With `merge`, a finite part of one velocity comes as one moment, however often it repeats, and without its places.
    """
    for duration, velocity, places in _moments(movement, start, False, merge, _NOWHERE):
        yield Moment(start, duration, velocity, places)
        start += duration


_NOWHERE = -1  # the number of the statement of what is in none
_Piece = tuple[Exact, Velocity, tuple[Place, ...]]
_Visit = tuple[Movement, Duration, bool]  # a part, where in its own time to begin, whether to go backward from there


class _Frame(NamedTuple):
    visits: Iterator[_Visit]
    rate: Fraction
    gain: Velocity
    statement: int
    places: tuple[Place, ...]


def _moments(movement: Movement, at: Duration, backward: bool, merge: bool, statement: int) -> Iterator[_Piece]:
    """An explicit stack, so that long chains of names cost no recursion; only voices within voices recurse."""
    stack = [_Frame(iter(((movement, at, backward),)), NORMAL, SAME, statement, ())]
    while stack:
        visits, rate, gain, statement, places = stack[-1]
        visit = next(visits, None)
        if visit is None:
            stack.pop()
            continue
        part, at, backward = visit
        left = at if backward else part.duration - at
        if not left:
            continue
        if isinstance(part, Hold) or (merge and part.uniform is not None and left != ENDLESS):
            assert part.uniform is not None
            assert not isinstance(left, float)
            own = (*places, Place(statement, part.span)) if isinstance(part, Hold) and part.span else places
            yield *_at_rate(left, part.uniform.times(gain), rate), own
        elif isinstance(part, Parallel):
            for duration, velocity, inner in _together(part, at, backward, merge, statement):
                yield *_at_rate(duration, velocity.times(gain), rate), places + inner
        elif isinstance(part, Pace):
            inside = iter(((part.body, at * part.rate, backward),))
            stack.append(_Frame(inside, rate * part.rate, gain, statement, places))
        elif isinstance(part, Gain):
            inside = iter(((part.body, at, backward),))
            stack.append(_Frame(inside, rate, gain.times(part.gain), statement, places))
        elif isinstance(part, Reverse):
            inside = iter(((part.body, part.duration - at, not backward),))
            stack.append(_Frame(inside, rate, gain, statement, places))
        elif isinstance(part, Use):
            inside = iter(((part.body, at, backward),))
            here = (*places, Place(statement, part.span)) if part.span else places
            stack.append(_Frame(inside, rate, gain, part.statement, here))
        elif isinstance(part, Repeat):
            stack.append(_Frame(_turns(part, at, backward), rate, gain, statement, places))
        elif isinstance(part, Series):
            stack.append(_Frame(_items(part, at, backward), rate, gain, statement, places))


def _at_rate(duration: Exact, velocity: Velocity, rate: Fraction) -> tuple[Exact, Velocity]:
    """Most is played at its own rate, and needs no arithmetic."""
    return (duration, velocity) if rate is NORMAL else (duration / rate, velocity.times(all_by(rate)))


def _items(part: Series, at: Duration, backward: bool) -> Iterator[_Visit]:
    index = (bisect_left if backward else bisect_right)(part.ends, at)
    if index == len(part.items):
        return
    begin = part.ends[index - 1] if index else 0
    yield part.items[index], at - begin, backward
    if backward:
        for item in reversed(part.items[:index]):
            yield item, item.duration, True
    else:
        for item in part.items[index + 1 :]:
            yield item, 0, False


def _turns(part: Repeat, at: Duration, backward: bool) -> Iterator[_Visit]:
    body = part.body
    if body.duration == ENDLESS:
        yield body, at, backward
        return
    turns, inside = divmod(at, body.duration)
    yield body, inside, backward
    rest: Iterable[int]
    if backward:
        rest = range(int(turns))
    elif part.times is None:
        rest = count()
    else:
        rest = range(int(turns) + 1, part.times)
    for _ in rest:
        yield body, body.duration if backward else 0, backward


def _together(part: Parallel, at: Duration, backward: bool, merge: bool, statement: int) -> Iterator[_Piece]:
    """Voices side by side: each piece ends where the first voice changes."""
    voices = [_moments(voice, at, backward, merge, statement) for voice in part.voices]
    pieces = [next(voice, None) for voice in voices]
    # Forward, the shortest voice ends first and cuts the others; backward, all arrive at their beginning together.
    while all(pieces):
        step = min(piece[0] for piece in pieces if piece)
        velocity = STILL
        places: tuple[Place, ...] = ()
        for piece in pieces:
            assert piece
            velocity, places = velocity.plus(piece[1]), places + piece[2]
        yield step, velocity, places
        for index, piece in enumerate(pieces):
            assert piece
            rest = piece[0] - step
            pieces[index] = (rest, piece[1], piece[2]) if rest else next(voices[index], None)


def parts(movement: Movement) -> tuple[Movement, ...]:
    """The movements it is made of, one level down."""
    if isinstance(movement, Series):
        return movement.items
    if isinstance(movement, Parallel):
        return movement.voices
    if isinstance(movement, (Repeat, Pace, Gain, Reverse, Use)):
        return (movement.body,)
    return ()
