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


class Source(NamedTuple):
    """A span that counts from the start of its statement, and that statement's ID.

    Movements stay valid while the statements before them change, so they hold no offsets in the document.
    """

    statement: int
    span: Span


class Moment(NamedTuple):
    """A stretch of constant velocity: its start and duration in beats, and the words that play."""

    start: Exact
    duration: Exact
    velocity: Velocity
    sources: tuple[Source, ...]


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


def bits(number: Exact) -> int:
    """The number of bits of an exact number, where 1 and -1 have none."""
    above, below = number.as_integer_ratio()  # one call, where `numerator` and `denominator` of a fraction are two
    return above.bit_length() + below.bit_length() - 2


def walk(movement: Movement, start: Exact = 0, *, merge: bool = False) -> Iterator[Moment]:
    """The moments of a movement from beat `start` on, in order, without gaps. None is empty.

    With `merge`, a finite part of constant velocity is one moment, no matter how often it repeats, without sources.
    """
    for duration, velocity, sources in _moments(movement, start, False, merge, _NOWHERE):
        yield Moment(start, duration, velocity, sources)
        start += duration


_NOWHERE = -1  # the statement ID of movements outside all statements
_Piece = tuple[Exact, Velocity, tuple[Source, ...]]
_Visit = tuple[Movement, Duration, bool]  # a part, the beat in it to start at, and whether to go backward


class _Frame(NamedTuple):
    visits: Iterator[_Visit]
    rate: Fraction
    gain: Velocity
    statement: int
    sources: tuple[Source, ...]


def _moments(movement: Movement, at: Duration, backward: bool, merge: bool, statement: int) -> Iterator[_Piece]:
    """Uses an explicit stack, so long chains of names need no recursion. Only nested voices recurse."""
    stack = [_Frame(iter(((movement, at, backward),)), NORMAL, SAME, statement, ())]
    while stack:
        visits, rate, gain, statement, sources = stack[-1]
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
            own = (*sources, Source(statement, part.span)) if isinstance(part, Hold) and part.span else sources
            yield *_at_rate(left, part.uniform.times(gain), rate), own
        elif isinstance(part, Parallel):
            for duration, velocity, inner in _together(part, at, backward, merge, statement):
                yield *_at_rate(duration, velocity.times(gain), rate), sources + inner
        elif isinstance(part, Pace):
            inside = iter(((part.body, at * part.rate, backward),))
            stack.append(_Frame(inside, rate * part.rate, gain, statement, sources))
        elif isinstance(part, Gain):
            inside = iter(((part.body, at, backward),))
            stack.append(_Frame(inside, rate, gain.times(part.gain), statement, sources))
        elif isinstance(part, Reverse):
            inside = iter(((part.body, part.duration - at, not backward),))
            stack.append(_Frame(inside, rate, gain, statement, sources))
        elif isinstance(part, Use):
            inside = iter(((part.body, at, backward),))
            here = (*sources, Source(statement, part.span)) if part.span else sources
            stack.append(_Frame(inside, rate, gain, part.statement, here))
        elif isinstance(part, Repeat):
            stack.append(_Frame(_turns(part, at, backward), rate, gain, statement, sources))
        elif isinstance(part, Series):
            stack.append(_Frame(_items(part, at, backward), rate, gain, statement, sources))


def _at_rate(duration: Exact, velocity: Velocity, rate: Fraction) -> tuple[Exact, Velocity]:
    """Most movements play at their normal rate, which needs no arithmetic."""
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
    """Parallel voices: each piece ends as soon as one voice changes."""
    voices = [_moments(voice, at, backward, merge, statement) for voice in part.voices]
    pieces = [next(voice, None) for voice in voices]
    # Forward, the shortest voice ends first and cuts off the others. Backward, all reach their start together.
    while all(pieces):
        step = min(piece[0] for piece in pieces if piece)
        velocity = STILL
        sources: tuple[Source, ...] = ()
        for piece in pieces:
            assert piece
            velocity, sources = velocity.plus(piece[1]), sources + piece[2]
        yield step, velocity, sources
        for index, piece in enumerate(pieces):
            assert piece
            rest = piece[0] - step
            pieces[index] = (rest, piece[1], piece[2]) if rest else next(voices[index], None)


def parts(movement: Movement) -> tuple[Movement, ...]:
    """The movements directly inside a movement."""
    if isinstance(movement, Series):
        return movement.items
    if isinstance(movement, Parallel):
        return movement.voices
    if isinstance(movement, (Repeat, Pace, Gain, Reverse, Use)):
        return (movement.body,)
    return ()
