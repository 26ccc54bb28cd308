"""The algebra of movement: a velocity over time, exact, and walked lazily. Standard library only.

A movement lasts `duration` beats (an exact fraction, or `ENDLESS`) and has a velocity in the robot's own frame, in
steps per beat and quarter turns per beat. Nothing here costs time or memory in proportion to a repeat count.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import accumulate, count
from typing import NamedTuple, TypeAlias

from improv_core.text import Span

ENDLESS = math.inf
Duration: TypeAlias = Fraction | float  # the only float is ENDLESS
ZERO, ONE = Fraction(0), Fraction(1)


class Velocity(NamedTuple):
    """Forward, leftward and upward steps per beat; counter-clockwise quarter turns per beat."""

    x: Fraction = ZERO
    y: Fraction = ZERO
    z: Fraction = ZERO
    yaw: Fraction = ZERO

    def plus(self, other: Velocity) -> Velocity:
        return Velocity(self.x + other.x, self.y + other.y, self.z + other.z, self.yaw + other.yaw)

    def times(self, other: Velocity) -> Velocity:
        """Each component times the same component of `other`."""
        return Velocity(self.x * other.x, self.y * other.y, self.z * other.z, self.yaw * other.yaw)


STILL = Velocity()
SAME = Velocity(ONE, ONE, ONE, ONE)


def all_by(factor: Fraction) -> Velocity:
    """The gain that multiplies every component by `factor`."""
    return Velocity(factor, factor, factor, factor)


class Moment(NamedTuple):
    """A stretch of constant velocity: start and duration in beats, and the source spans that are playing in it."""

    start: Fraction
    duration: Fraction
    velocity: Velocity
    spans: tuple[Span, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Movement:
    """A movement. Made by the functions below, never directly.

    `uniform` is its velocity where that never changes; `depth` is how many levels of voices stand within voices;
    `bits` is how long the fractions of its moments may get from the factors around them.
    """

    duration: Duration
    uniform: Velocity | None
    depth: int
    bits: int


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
    span: Span


def hold(velocity: Velocity, duration: Fraction = ONE, span: Span | None = None) -> Movement:
    """One velocity for `duration` beats, written at `span`."""
    return Hold(duration, velocity, 0, 0, velocity, span)


def series(items: Sequence[Movement]) -> Movement:
    """One after the other; what follows an endless item is never reached."""
    if len(items) == 1:
        return items[0]
    ends = tuple(accumulate((item.duration for item in items), initial=ZERO))[1:]
    velocities = {item.uniform for item in items if item.duration}
    uniform = velocities.pop() if len(velocities) == 1 else None
    depth = max((item.depth for item in items), default=0)
    bits = max((item.bits for item in items), default=0)
    return Series(ends[-1] if ends else ZERO, uniform, depth, bits, tuple(items), ends)


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
    return Parallel(min(voice.duration for voice in voices), uniform, depth, bits, tuple(voices))


def repeat(body: Movement, times: int | None = None) -> Movement:
    """So many times, or for ever. Repeating what takes no time takes no time."""
    if not body.duration or times == 0:
        return series(())
    duration = ENDLESS if times is None else body.duration * times
    return Repeat(duration, body.uniform, body.depth, body.bits, body, times)


def pace(body: Movement, rate: Fraction) -> Movement:
    """The same path, `rate` times as fast."""
    if not body.duration:
        return body
    duration = body.duration / rate if body.duration != ENDLESS else ENDLESS
    uniform = body.uniform and body.uniform.times(all_by(rate))
    return Pace(duration, uniform, body.depth, body.bits + bits(rate), body, rate)


def gain(body: Movement, factors: Velocity) -> Movement:
    """The same time, each component of the velocity multiplied."""
    if not body.duration:
        return body
    uniform = body.uniform and body.uniform.times(factors)
    longer = max(bits(factor) for factor in factors)
    return Gain(body.duration, uniform, body.depth, body.bits + longer, body, factors)


def reverse(body: Movement) -> Movement:
    """What is performed, in reverse order. Raises ValueError if it is endless."""
    if body.duration == ENDLESS:
        raise ValueError("an endless movement has no end to start from")
    return Reverse(body.duration, body.uniform, body.depth, body.bits, body)


def use(body: Movement, span: Span) -> Movement:
    """The movement behind a name, used at `span`."""
    return Use(body.duration, body.uniform, body.depth, body.bits, body, span)


def bits(number: Fraction) -> int:
    """How long an exact number is; 1 and -1 count as nothing."""
    return abs(number.numerator).bit_length() + number.denominator.bit_length() - 2


def walk(movement: Movement, start: Fraction = ZERO, *, merge: bool = False) -> Iterator[Moment]:
    """The moments of a movement from beat `start` on, in order, without gaps, each longer than zero.

    With `merge`, a finite part of one velocity comes as one moment, however often it repeats, and without its spans.
    """
    for duration, velocity, spans in _moments(movement, start, False, merge):
        yield Moment(start, duration, velocity, spans)
        start += duration


_Piece = tuple[Fraction, Velocity, tuple[Span, ...]]
_Visit = tuple[Movement, Duration, bool]  # a part, where in its own time to begin, whether to go backward from there


class _Frame(NamedTuple):
    visits: Iterator[_Visit]
    rate: Fraction
    gain: Velocity
    spans: tuple[Span, ...]


def _moments(movement: Movement, at: Duration, backward: bool, merge: bool) -> Iterator[_Piece]:
    """An explicit stack, so that long chains of names cost no recursion; only voices within voices recurse."""
    stack = [_Frame(iter(((movement, at, backward),)), ONE, SAME, ())]
    while stack:
        visits, rate, gain, spans = stack[-1]
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
            assert isinstance(left, Fraction)
            own = (*spans, part.span) if isinstance(part, Hold) and part.span else spans
            yield left / rate, part.uniform.times(gain).times(all_by(rate)), own
        elif isinstance(part, Parallel):
            for duration, velocity, inner in _together(part, at, backward, merge):
                yield duration / rate, velocity.times(gain).times(all_by(rate)), spans + inner
        elif isinstance(part, Pace):
            stack.append(_Frame(iter(((part.body, at * part.rate, backward),)), rate * part.rate, gain, spans))
        elif isinstance(part, Gain):
            stack.append(_Frame(iter(((part.body, at, backward),)), rate, gain.times(part.gain), spans))
        elif isinstance(part, Reverse):
            stack.append(_Frame(iter(((part.body, part.duration - at, not backward),)), rate, gain, spans))
        elif isinstance(part, Use):
            stack.append(_Frame(iter(((part.body, at, backward),)), rate, gain, (*spans, part.span)))
        elif isinstance(part, Repeat):
            stack.append(_Frame(_turns(part, at, backward), rate, gain, spans))
        elif isinstance(part, Series):
            stack.append(_Frame(_items(part, at, backward), rate, gain, spans))


def _items(part: Series, at: Duration, backward: bool) -> Iterator[_Visit]:
    index = (bisect_left if backward else bisect_right)(part.ends, at)
    if index == len(part.items):
        return
    begin = part.ends[index - 1] if index else ZERO
    yield part.items[index], at - begin, backward
    if backward:
        for item in reversed(part.items[:index]):
            yield item, item.duration, True
    else:
        for item in part.items[index + 1 :]:
            yield item, ZERO, False


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
        yield body, body.duration if backward else ZERO, backward


def _together(part: Parallel, at: Duration, backward: bool, merge: bool) -> Iterator[_Piece]:
    """Voices side by side: each piece ends where the first voice changes."""
    voices = [_moments(voice, at, backward, merge) for voice in part.voices]
    pieces = [next(voice, None) for voice in voices]
    # Forward, the shortest voice ends first and cuts the others; backward, all arrive at their beginning together.
    while all(pieces):
        step = min(piece[0] for piece in pieces if piece)
        velocity = STILL
        spans: tuple[Span, ...] = ()
        for piece in pieces:
            assert piece
            velocity, spans = velocity.plus(piece[1]), spans + piece[2]
        yield step, velocity, spans
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
