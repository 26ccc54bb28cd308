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
