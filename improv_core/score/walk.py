"""The walk of a movement: its stretches of constant velocity, one by one, however often it repeats.

It may start at any beat and go backward. What comes before that beat is computed, not walked: that takes time in
proportion to the depth of the movement and to the items of the shuffles around that beat.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import accumulate, count
from typing import NamedTuple

from improv_core.score.dice import (
    ROBOTS,
    Chance,
    Choose,
    Dice,
    Seed,
    Shuffle,
    Throwing,
    at_turn,
    decided,
    dice_of,
    in_order,
)
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
from improv_core.score.ramps import Ramp, Step
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


def walk(movement: Movement, start: Exact = 0, *, merge: bool = False, dice: Dice | None = None) -> Iterator[Moment]:
    """The moments of a movement from beat `start` on, in order, without gaps. None is empty.

    With `merge`, a finite part of constant velocity is one moment, no matter how often it repeats, without sources.
    `dice` are those at its beginning: by default, the first of the robots' stream.
    """
    if movement.dice and not dice:
        dice = dice_of(ROBOTS)
    for duration, velocity, sources in _moments((movement, start, False, dice), merge, _NOWHERE):
        yield Moment(start, duration, velocity, sources)
        start += duration


_NOWHERE = -1  # the statement ID of movements outside all statements
_Piece = tuple[Exact, Velocity, tuple[Source, ...]]
_Visit = tuple[Movement, Duration, bool, Dice | None]
"""A part, the beat in it to start at, whether to go backward, and the dice at its start if it has any."""


class _Frame(NamedTuple):
    visits: Iterator[_Visit]
    rate: Fraction
    gain: Velocity
    statement: int
    sources: tuple[Source, ...]


def _moments(visit: _Visit, merge: bool, statement: int) -> Iterator[_Piece]:
    """Uses an explicit stack, so long chains of names need no recursion. Only nested voices and ramps recurse."""
    stack = [_Frame(iter((visit,)), NORMAL, SAME, statement, ())]
    while stack:
        visits, rate, gain, statement, sources = stack[-1]
        due = next(visits, None)
        if due is None:
            stack.pop()
            continue
        part, at, backward, dice = due
        left = at if backward else part.duration - at
        while left:
            if isinstance(part, Hold) or (merge and part.uniform is not None and left != ENDLESS):
                assert part.uniform is not None
                assert not isinstance(left, float)
                own = (*sources, Source(statement, part.span)) if isinstance(part, Hold) and part.span else sources
                yield *_at_rate(left, part.uniform.times(gain), rate), own
                break
            if isinstance(part, Use):
                sources = (*sources, Source(statement, part.span)) if part.span else sources
                statement, part = part.statement, part.body
            elif isinstance(part, Series):
                stack.append(_Frame(_items(part, at, backward, dice), rate, gain, statement, sources))
                break
            elif isinstance(part, Repeat):
                stack.append(_Frame(_turns(part, at, backward, dice), rate, gain, statement, sources))
                break
            elif isinstance(part, Pace):
                rate *= part.rate
                at, left, part = at * part.rate, left * part.rate, part.body
            elif isinstance(part, Gain):
                gain, part = gain.times(part.gain), part.body
            elif isinstance(part, Reverse):
                at, backward, part = part.duration - at, not backward, part.body
            elif isinstance(part, Shuffle):
                assert dice
                stack.append(_Frame(_shuffled(part, at, backward, dice), rate, gain, statement, sources))
                break
            elif isinstance(part, (Parallel, Ramp)):
                pieces = (
                    _together(part, at, backward, dice, merge, statement)
                    if isinstance(part, Parallel)
                    else _in_steps(part, at, backward, dice, merge, statement)
                )
                for duration, velocity, inner in pieces:
                    yield *_at_rate(duration, velocity.times(gain), rate), sources + inner
                break
            else:
                assert isinstance(part, (Choose, Chance, Seed, Throwing))
                assert dice
                part, dice = decided(part, dice)


def _at_rate(duration: Exact, velocity: Velocity, rate: Fraction) -> tuple[Exact, Velocity]:
    """Most movements play at their normal rate, which needs no arithmetic."""
    return (duration, velocity) if rate is NORMAL else (duration / rate, velocity.times(all_by(rate)))


def _items(part: Series, at: Duration, backward: bool, dice: Dice | None) -> Iterator[_Visit]:
    if dice is None or not part.first_throws:
        return _one_by_one(part.items, part.ends, at, backward, None)
    return _one_by_one(part.items, part.ends, at, backward, lambda index: dice.after(part.first_throws[index]))


def _shuffled(part: Shuffle, at: Duration, backward: bool, dice: Dice) -> Iterator[_Visit]:
    items, dice_of_items = zip(*in_order(part, dice), strict=True)
    ends = list(accumulate(item.duration for item in items))
    return _one_by_one(items, ends, at, backward, dice_of_items.__getitem__)


def _one_by_one(
    items: Sequence[Movement],
    ends: Sequence[Duration],
    at: Duration,
    backward: bool,
    dice_of_item: Callable[[int], Dice] | None,
) -> Iterator[_Visit]:
    first = (bisect_left if backward else bisect_right)(ends, at)
    if first == len(items):
        return
    begin = ends[first - 1] if first else 0
    yield items[first], at - begin, backward, dice_of_item and dice_of_item(first)
    if backward:
        for index in range(first - 1, -1, -1):
            yield items[index], items[index].duration, True, dice_of_item and dice_of_item(index)
    else:
        for index in range(first + 1, len(items)):
            yield items[index], 0, False, dice_of_item and dice_of_item(index)


def _turns(part: Repeat, at: Duration, backward: bool, dice: Dice | None) -> Iterator[_Visit]:
    body, turn = part.body, 0
    if body.duration != ENDLESS:
        turns, at = divmod(at, body.duration)
        turn = int(turns)
    onward: Iterable[int] = count(turn) if part.times is None else range(turn, part.times)
    for each in range(turn, -1, -1) if backward else onward:
        yield body, at, backward, dice and at_turn(part, dice, each)
        at = body.duration if backward else 0


def _in_steps(
    part: Ramp, at: Duration, backward: bool, dice: Dice | None, merge: bool, statement: int
) -> Iterator[_Piece]:
    """A ramp: each piece ends as soon as its body or its rate changes."""
    assert not isinstance(at, float)
    steps = part.steps_from(at, backward)
    beats, rate = next(steps)
    for left, velocity, sources in _moments((part.body, part.played(at), backward, dice), merge, statement):
        while beats * rate <= left:
            yield beats, velocity.times(all_by(rate)), sources
            left -= beats * rate
            beats, rate = next(steps, _NO_STEP)
            if not left:
                break
        else:
            yield left / rate, velocity.times(all_by(rate)), sources
            beats -= left / rate


_NO_STEP = Step(Fraction(0), NORMAL)  # after the last one, at which the body ends too


def _together(
    part: Parallel, at: Duration, backward: bool, dice: Dice | None, merge: bool, statement: int
) -> Iterator[_Piece]:
    """Parallel voices: each piece ends as soon as one voice changes."""
    voices = [
        _moments((voice, at, backward, dice and dice.inside(index)), merge, statement)
        for index, voice in enumerate(part.items)
        if voice.duration
    ]
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
