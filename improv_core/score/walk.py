"""The walk of a movement: its stretches of constant velocity, one by one, however often it repeats."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Iterator
from fractions import Fraction
from itertools import count
from typing import NamedTuple

from improv_core.score.movement import (
    ENDLESS,
    NORMAL,
    SAME,
    STILL,
    Duration,
    Exact,
    Gain,
    Hold,
    Movement,
    Pace,
    Parallel,
    Repeat,
    Reverse,
    Series,
    Use,
    Velocity,
    all_by,
)
from improv_core.text import Span


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
