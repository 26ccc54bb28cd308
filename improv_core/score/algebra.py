"""The algebra of movements: holding a velocity, series, voices, repeats, and changes of rate, size, and direction.
Standard library only. `score/walk.py` walks these movements."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import accumulate as count_up
from itertools import count
from typing import ClassVar

from improv_core.score import fields
from improv_core.score.bounds import UNBOUNDED, amplified, either, held, in_parallel, opened, sped_up
from improv_core.score.measured import Measure, bound_of
from improv_core.score.movement import (
    ENDLESS,
    STILL,
    Around,
    Duration,
    Exact,
    Factors,
    InTurn,
    JsonForm,
    Lengths,
    Movement,
    Piece,
    Piecewise,
    Several,
    Single,
    Source,
    Through,
    Velocity,
    Visit,
    all_by,
    bits,
    exact,
    makes,
    require_end,
)
from improv_core.score.throws import Dice, T
from improv_core.text import Span
from improv_core.values import value


@value(frozen=True, slots=True, eq=False)
class Hold(Movement):
    """A constant velocity, written at `span`."""

    velocity: Velocity
    span: Span | None

    NAME = "hold"
    FIELDS: ClassVar[tuple[tuple[str, JsonForm], ...]] = (
        ("velocity", fields.VELOCITY),
        ("duration", fields.BEATS),
        ("span", fields.SPAN),
    )


@value(frozen=True, slots=True, eq=False)
class Series(Several, InTurn):
    """Movements that play one after another."""

    first_throws: tuple[int, ...]  # the throw at which each item begins, counted from the first; empty without dice

    NAME = "series"

    @property
    def ends(self) -> Sequence[Duration]:
        """The beat at which each item ends."""
        known = self.known
        if known.ends is None:
            known.ends = tuple(count_up(item.duration for item in self.items))
        return known.ends

    def throw_of(self, index: int, throw: T) -> T:
        return throw.after(self.first_throws[index]) if self.first_throws else throw

    def visits(self, at: Duration, backward: bool, dice: Dice | None) -> Iterator[Visit]:
        ends = self.ends if at else ()
        if dice is None or not self.first_throws:
            return one_by_one(self.items, ends, at, backward, None)
        return one_by_one(self.items, ends, at, backward, lambda index: self.throw_of(index, dice))


def items_of(movement: Movement) -> tuple[Movement, ...]:
    """Return the items of a series; any other movement is its only item."""
    return movement.items if isinstance(movement, Series) else (movement,)


@value(frozen=True, slots=True, eq=False)
class Parallel(Several, Piecewise):
    """Voices. With dice, an empty voice stays among them, because each throws from the stream of its index."""

    NAME = "parallel"

    def throw_of(self, index: int, throw: T) -> T:
        return throw.inside(index)

    def lasts(self, parts: Sequence[Lengths]) -> Lengths:
        ending = [each.longest for each in parts if not each.may_be_empty]
        return Lengths(
            min(each.shortest for each in parts),
            min(ending) if ending else max(each.longest for each in parts),
            not ending,
        )

    def pieces(
        self, at: Duration, backward: bool, dice: Dice | None, walk: Callable[[Visit], Iterator[Piece]]
    ) -> Iterator[Piece]:
        """Yield pieces, each of which ends as soon as one voice changes."""
        voices = [
            walk(Visit(voice, at, backward, dice and dice.inside(index)))
            for index, voice in enumerate(self.items)
            if voice.duration
        ]
        playing = [next(voice, None) for voice in voices]
        # Forward, the shortest voice ends first and cuts off the others. Backward, all reach their start together.
        while all(playing):
            step = min(piece[0] for piece in playing if piece)
            velocity = STILL
            sources: tuple[Source, ...] = ()
            for piece in playing:
                assert piece
                velocity, sources = velocity.plus(piece[1]), sources + piece[2]
            yield step, velocity, sources
            for index, piece in enumerate(playing):
                assert piece
                rest = piece[0] - step
                playing[index] = (rest, piece[1], piece[2]) if rest else next(voices[index], None)


@value(frozen=True, slots=True, eq=False)
class Repeat(Single, InTurn):
    """A movement that plays a number of times, or forever. Repeating an empty movement gives an empty movement."""

    times: int | None

    NAME = "repeat"
    FIELDS = (("times", fields.TIMES),)

    def throw_of(self, index: int, throw: T) -> T:
        """Return a throw of a stream of their own for the turns of an endless repeat."""
        return throw.inside(0) if self.times is None else throw

    def dice_at(self, turn: int, dice: Dice) -> Dice:
        return (dice.inside(0) if self.times is None else dice).after(turn * self.body.bounds.throws)

    def lasts(self, parts: Sequence[Lengths]) -> Lengths:
        (body,) = parts
        if self.times is None:
            return Lengths(ENDLESS, ENDLESS, False)
        longest = body.longest * self.times if self.times else 0
        return Lengths(body.shortest * self.times if self.times else 0, longest, body.may_be_empty or not longest)

    def visits(self, at: Duration, backward: bool, dice: Dice | None) -> Iterator[Visit]:
        body, turn = self.body, 0
        if not body.duration:  # its turns are open and, if no sense holds, take no time
            yield Visit(STANDING, at, backward, None)
            return
        if body.duration != ENDLESS:
            turns, at = divmod(at, body.duration)
            turn = int(turns)
            if backward and turn and not at:
                turn, at = turn - 1, body.duration
        if backward:
            turns_left: Iterator[int] = iter(range(turn, -1, -1))
        else:
            turns_left = count(turn) if self.times is None else iter(range(turn, self.times))
        for each in turns_left:
            yield Visit(body, at, backward, dice and self.dice_at(each, dice))
            at = body.duration if backward else 0


@value(frozen=True, slots=True, eq=False)
class Pace(Single, Through):
    """The same path, `rate` times as fast."""

    rate: Fraction

    NAME = "pace"
    FIELDS = (("rate", fields.RATE),)

    def within(self, around: Around) -> Around:
        rate, gain, statement, sources = around
        return Around(rate * self.rate, gain, statement, sources)

    def inner(self, at: Duration, backward: bool, dice: Dice | None) -> Visit:
        return Visit(self.body, at * self.rate, backward, dice)


@value(frozen=True, slots=True, eq=False)
class Gain(Single, Through):
    """The same duration, with each component of the velocity multiplied.

    In this language, all components of a gain have the same absolute value, so it scales every length equally.
    """

    gain: Factors

    NAME = "gain"
    FIELDS = (("gain", fields.FACTORS),)

    def within(self, around: Around) -> Around:
        rate, gain, statement, sources = around
        return Around(rate, gain.times(self.gain), statement, sources)


@value(frozen=True, slots=True, eq=False)
class Reverse(Single, Through):
    """The same moments in reverse order."""

    NAME = "reverse"

    def inner(self, at: Duration, backward: bool, dice: Dice | None) -> Visit:
        return Visit(self.body, self.duration - at, not backward, dice)


@value(frozen=True, slots=True, eq=False)
class FromStatement(Single, Through):
    """A movement written in the statement with this ID, used by a name at `span`."""

    span: Span | None
    statement: int

    NAME = "use"
    FIELDS = (("span", fields.SPAN), ("statement", fields.STATEMENT))

    def within(self, around: Around) -> Around:
        return Around(around.rate, around.gain, self.statement, around.at(self.span))


def one_by_one(
    items: Sequence[Movement],
    ends: Sequence[Duration],
    at: Duration,
    backward: bool,
    dice_of_item: Callable[[int], Dice] | None,
) -> Iterator[Visit]:
    """Yield items that play one after another. `ends` are the beats at which they end, unless `at` is 0."""
    first = bisect_left(ends, at) if backward else bisect_right(ends, at) if at else 0
    if first == len(items):
        return
    begin = ends[first - 1] if first else 0
    yield Visit(items[first], at - begin, backward, dice_of_item and dice_of_item(first))
    if backward:
        for index in range(first - 1, -1, -1):
            yield Visit(items[index], items[index].duration, True, dice_of_item and dice_of_item(index))
    else:
        for index in range(first + 1, len(items)):
            yield Visit(items[index], 0, False, dice_of_item and dice_of_item(index))


@makes(Hold)
def hold(velocity: Velocity, duration: Exact = 1, span: Span | None = None) -> Movement:
    """Return a constant velocity for `duration` beats, written at `span`."""
    x, y, z, yaw = map(bound_of, velocity)
    return Hold(duration, velocity, held(x, y, z, yaw, float(duration), _longest(velocity)), velocity, span)


def _longest(velocity: Velocity) -> int:
    """Return the most bits of a number that a program measures in a velocity."""
    return max((bits(exact(Fraction(each))) for one in velocity if isinstance(one, Measure) for each in one), default=0)


def stand(duration: Exact) -> Movement:
    """Return a movement that stands still for `duration` beats, or an empty one. It is not written anywhere, so it
    never counts as an item that is too short."""
    return Hold(duration, STILL, UNBOUNDED, STILL, None) if duration else series(())


@makes(Series)
def series(items: Sequence[Movement]) -> Movement:
    """Return the items one after another. Items after an endless one are never reached."""
    if len(items) == 1:
        return items[0]
    end: Duration = 0
    uniform: Velocity | None = None
    bounds = items[0].bounds if items else UNBOUNDED
    for item in items:  # a single loop, because most of the work at a keystroke goes through here
        if item.duration:
            if not end:
                uniform = item.uniform
            elif uniform is not item.uniform and uniform != item.uniform:
                uniform = None
            end += item.duration
        if item.bounds is not bounds:
            bounds = either(bounds, item.bounds)
    if bounds.open:
        bounds = opened(bounds)
    first_throws: tuple[int, ...] = ()
    if bounds.dice:
        *reached, throws = count_up((item.bounds.throws for item in items), initial=0)
        bounds, first_throws = replace(bounds, throws=throws), tuple(reached)
    return Series(end, uniform, bounds, tuple(items), first_throws)


@makes(Parallel)
def parallel(voices: Sequence[Movement]) -> Movement:
    """Return all voices at once: velocities add up, the shortest voice ends all, and empty voices are ignored."""
    playing = [voice for voice in voices if voice.duration or voice.open]
    dice = len(voices) > 1 and any(voice.bounds.dice for voice in voices)
    if not dice and len(playing) < 2:
        return series(playing)
    uniform: Velocity | None = STILL if playing else None
    for voice in playing:
        uniform = uniform.plus(voice.uniform) if uniform and voice.uniform else None
    bounds = in_parallel(tuple(voice.bounds for voice in playing), dice)
    duration = min((voice.duration for voice in playing if voice.duration), default=0)
    return Parallel(duration, uniform, bounds, tuple(voices if dice else playing))


@makes(Repeat)
def repeat(body: Movement, times: int | None = None) -> Movement:
    """Repeat the movement `times` times, or forever if None. Repeating an empty movement gives an empty movement."""
    if times == 0 or not (body.duration or body.open):
        if not body.bounds.dice:
            return series(())
        duration: Duration = 0
    else:
        duration = ENDLESS if times is None else body.duration * times
    uniform = body.uniform if body.duration else STILL  # after turns that take no time, the robot stands still
    bounds = opened(body.bounds) if body.bounds.open else body.bounds
    if bounds.dice:
        bounds = replace(bounds, throws=1 if times is None else bounds.throws * times)
    return Repeat(duration, uniform, bounds, body, times)


@makes(Pace)
def pace(body: Movement, rate: Fraction) -> Movement:
    """Return the same path, `rate` times as fast."""
    if not (body.duration or body.open):
        return body
    duration = ENDLESS if isinstance(body.duration, float) else _quotient(body.duration, rate)
    uniform = body.uniform and body.uniform.times(all_by(exact(rate)))
    return Pace(duration, uniform, sped_up(body.bounds, *rate.as_integer_ratio()), body, rate)


def _quotient(number: Exact, divisor: Fraction) -> Exact:
    """Return an exact number divided by a fraction, in half of the time that its own operator takes."""
    above, below = number.as_integer_ratio()
    over, under = divisor.as_integer_ratio()
    whole, rest = divmod(above * under, below * over)
    return Fraction(above * under, below * over) if rest else whole


def fit(body: Movement, beats: Exact) -> Movement:
    """Return the same path in exactly `beats` beats. Raises ValueError if the movement is endless or open."""
    require_end(body)
    assert not isinstance(body.duration, float)
    return pace(body, Fraction(body.duration) / beats)


@makes(Gain)
def gain(body: Movement, factors: Factors) -> Movement:
    """Return the same duration, with each component of the velocity multiplied."""
    if not (body.duration or body.open):
        return body
    uniform = body.uniform and body.uniform.times(factors)
    return Gain(body.duration, uniform, amplified(body.bounds, factors), body, factors)


@makes(Reverse)
def reverse(body: Movement) -> Movement:
    """Return the same moments in reverse order. Raises ValueError if the movement is endless or open."""
    require_end(body)
    return Reverse(body.duration, body.uniform, body.bounds, body)


def accumulate(items: Sequence[Movement]) -> Movement:
    """Of items a, b, c, return a, then a b, then a b c. Each beginning is shared by all that are longer."""
    return series(list(count_up(items, lambda beginning, item: series((beginning, item)))))


@makes(FromStatement)
def from_statement(body: Movement, span: Span | None, statement: int) -> Movement:
    """Return a movement written in the statement with this ID, used by a name at `span`."""
    return FromStatement(body.duration, body.uniform, body.bounds, body, span, statement)


STANDING = repeat(stand(1))
"""Standing still forever."""
