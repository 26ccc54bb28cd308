"""The execution of an open movement, step by step, by the values of senses. Standard library only."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from copy import copy
from functools import partial
from itertools import chain, tee
from typing import NamedTuple

from improv_core.score.algebra import Parallel, Repeat
from improv_core.score.movement import (
    ENDLESS,
    STILL,
    Around,
    Duration,
    Exact,
    InTurn,
    Movement,
    Source,
    Through,
    Velocity,
    Visit,
    all_by,
)
from improv_core.score.reactions import If, Pause, Until, reactions
from improv_core.score.throws import Dice
from improv_core.score.walk import Moment, walk

Sensed = Callable[[str], bool | None]
"""A function that returns whether a sense is true now; None if that is unknown: then no condition about it holds."""
Performed = tuple[Velocity, tuple[Source, ...]]
"""A velocity, and the words that play."""


class UnforeseenError(Exception):
    """Raised if a movement has to be performed to be known at a beat, even if no sense is true until then."""


def begin(movement: Movement, dice: Dice | None, around: Around, start: Duration = 0) -> Execution:
    """Return the execution of a movement from its beat `start` on, before it ends, with its dice and its surroundings.

    Up to that beat, it is as if no sense had been true. That is computed, not performed: it takes time in proportion to
    the depth of the movement. Raises UnforeseenError if that can't be.
    """
    if start and start >= movement.duration:
        _require_foreseen(movement)
        return _Closed(movement, dice, around, start)
    while movement.open:
        if kind := _KINDS.get(movement.NAME):
            return kind(movement, dice, around, start)
        around = movement.within(around)
        if isinstance(movement, InTurn):
            return _Sequence(movement, dice, around, start)
        assert isinstance(movement, Through)
        movement, start, _, dice = movement.inner(start, False, dice)
    return _Closed(movement, dice, around, start)


def _require_foreseen(movement: Movement) -> None:
    """Raise UnforeseenError unless a movement surely lasts as long as its `duration` says if no sense is true."""
    for each in reactions(movement):
        if isinstance(each, If) or each.wanted:
            continue
        # An `until not` stands until the next whole beat, so that it matters when it begins.
        if isinstance(each, Until) or not each.body.duration:
            raise UnforeseenError


class Decision(NamedTuple):
    """The decision of a word of senses at a beat: whether its condition held. `sources` ends with that word."""

    sources: tuple[Source, ...]
    beat: Exact
    held: bool


class Execution(ABC):
    """A movement in performance. Times are beats of the performance, apart from those in which it is frozen."""

    @abstractmethod
    def is_over(self, beat: Exact) -> bool:
        """Return whether no time is left. Begins what begins now, and reads no sense: an undecided `if` is not over."""

    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        """Read senses, outermost first, up to the first that decides something. For what is not over."""
        return None

    @abstractmethod
    def left(self) -> Duration:
        """Return the beats until the next change that is certain."""

    @abstractmethod
    def velocity(self) -> Performed: ...

    @abstractmethod
    def pass_time(self, beats: Exact) -> None: ...

    def watched(self) -> Iterator[str]:
        return iter(())

    def foresee(self) -> None:
        """Compute what comes next before its time, if that is known."""
        return

    def fork(self) -> Execution:
        """Return a copy, which continues by itself."""
        fork = copy(self)
        for name, value in vars(self).items():
            if isinstance(value, Execution):
                setattr(fork, name, value.fork())
        return fork


class _Closed(Execution):
    """A closed movement. It reads nothing."""

    def __init__(self, movement: Movement, dice: Dice | None, around: Around, start: Duration) -> None:
        assert not isinstance(start, float)
        self._around = around
        self._walk = partial(walk, movement, dice=dice, statement=around.statement)
        self._moments = self._walk(start)
        self._walked: Exact = start
        self._left: Duration = 0
        self._performed: Performed | None = None
        self._foreseen: list[Moment | None] = []
        self._next()

    def is_over(self, beat: Exact) -> bool:
        return self._performed is None

    def left(self) -> Duration:
        return self._left

    def velocity(self) -> Performed:
        assert self._performed
        return self._performed

    def pass_time(self, beats: Exact) -> None:
        self._left -= beats
        if not self._left:
            self._next()

    def foresee(self) -> None:
        if not self._foreseen and self._performed:
            self._foreseen = [next(self._moments, None)]

    def fork(self) -> Execution:
        fork = copy(self)
        fork._moments, fork._foreseen = self._walk(self._walked), []
        return fork

    def _next(self) -> None:
        moment, around = self._foreseen.pop() if self._foreseen else next(self._moments, None), self._around
        if moment:
            self._walked = moment.start + moment.duration
            self._left = moment.duration / around.rate
            velocity = moment.velocity.times(around.gain).times(all_by(around.rate))
            self._performed = velocity, around.sources + moment.sources
        else:
            self._performed = None


class _Through(Execution):
    """A movement in which one other is performed at a time, `_inner`, unless it stands still, for `_stands` beats."""

    _inner: Execution | None
    _stands: Exact = 0
    _source: tuple[Source, ...] = ()
    """The words that play while it stands."""

    def is_over(self, beat: Exact) -> bool:
        return not self._stands and (self._inner is None or self._inner.is_over(beat))

    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        return None if self._stands or not self._inner else self._inner.read(sensed, beat)

    def left(self) -> Duration:
        return self._stands or self._playing.left()

    def velocity(self) -> Performed:
        return (STILL, self._source) if self._stands else self._playing.velocity()

    def pass_time(self, beats: Exact) -> None:
        if self._stands:
            self._stands -= beats
        else:
            self._playing.pass_time(beats)

    def watched(self) -> Iterator[str]:
        return iter(()) if self._stands else self._playing.watched()

    @property
    def _playing(self) -> Execution:
        assert self._inner
        return self._inner


class _Sequence(_Through):
    """Movements one after another. Each begins when the one before it is over."""

    def __init__(self, movement: InTurn, dice: Dice | None, around: Around, start: Duration) -> None:
        self._visits = movement.visits(start, False, dice)
        self._around = around
        first = next(self._visits, None)
        if start and first and (first.part is not movement.parts[0] or first.at != start):
            _require_foreseen(movement)
        self._begin(first)

    def is_over(self, beat: Exact) -> bool:
        while self._inner and self._inner.is_over(beat):
            self._begin(next(self._visits, None))
        return self._inner is None

    def fork(self) -> Execution:
        fork = super().fork()
        assert isinstance(fork, _Sequence)
        self._visits, fork._visits = tee(self._visits)
        return fork

    def _begin(self, visit: Visit | None) -> None:
        self._inner = begin(visit.part, visit.dice, self._around, visit.at) if visit else None


class _Rounds(_Through):
    """A repeat. A round that takes no time ends it or, if it is endless, makes it stand until the next whole beat."""

    def __init__(self, movement: Repeat, dice: Dice | None, around: Around, start: Duration) -> None:
        self._endless = movement.times is None
        self._repeats = movement, dice, around
        body, turn, at = movement.body, 0, start
        if start and not body.duration:
            if dice:
                raise UnforeseenError  # how many turns have taken no time decides what it throws
            at = 0
        elif start and not isinstance(body.duration, float):
            turns, at = divmod(start, body.duration)
            turn = int(turns)
        if turn:
            _require_foreseen(body)
        self._turn = turn - 1
        self._inner = self._next(at)
        self._took: Duration = at

    def is_over(self, beat: Exact) -> bool:
        while not self._stands and self._inner and self._inner.is_over(beat):
            if self._took or not self._endless:
                self._inner = self._next() if self._took else None
            else:
                self._inner, self._stands = self._next(), to_next_whole(beat)
            self._took = 0
        return self._inner is None

    def pass_time(self, beats: Exact) -> None:
        if not self._stands:
            self._took += beats
        super().pass_time(beats)

    def _next(self, at: Duration = 0) -> Execution | None:
        movement, dice, around = self._repeats
        self._turn += 1
        if movement.times is not None and self._turn >= movement.times:
            return None
        return begin(movement.body, dice and movement.dice_at(self._turn, dice), around, at)


class _Together(Execution):
    """Voices at once. The first that is over ends all, except that a voice that is empty when it begins is ignored."""

    def __init__(self, movement: Parallel, dice: Dice | None, around: Around, start: Duration) -> None:
        dice = dice if movement.dice else None
        self._voices = []
        for index, voice in enumerate(movement.items):
            if voice.duration or not start:
                self._voices.append(begin(voice, dice and dice.inside(index), around, start))
            else:
                _require_foreseen(voice)
        self._begins = not start

    def is_over(self, beat: Exact) -> bool:
        over = [voice for voice in self._voices if voice.is_over(beat)]
        if self._begins:
            self._voices = [voice for voice in self._voices if voice not in over]
        return not self._voices or (bool(over) and not self._begins)

    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        return next(filter(None, (voice.read(sensed, beat) for voice in self._voices)), None)

    def left(self) -> Duration:
        return min(voice.left() for voice in self._voices)

    def velocity(self) -> Performed:
        velocity = STILL
        sources: tuple[Source, ...] = ()
        for voice in self._voices:
            own, words = voice.velocity()
            velocity, sources = velocity.plus(own), sources + words
        return velocity, sources

    def pass_time(self, beats: Exact) -> None:
        self._begins = False
        for voice in self._voices:
            voice.pass_time(beats)

    def watched(self) -> Iterator[str]:
        return chain.from_iterable(voice.watched() for voice in self._voices)

    def fork(self) -> Execution:
        fork = copy(self)
        fork._voices = [voice.fork() for voice in self._voices]
        return fork


class _Until(_Through):
    """An `until`: as soon as its condition holds, the robot stands until the next whole beat, or until it would end."""

    def __init__(self, movement: Until, dice: Dice | None, around: Around, start: Duration) -> None:
        if start and not movement.wanted:
            raise UnforeseenError
        self._condition = movement.condition
        self._source = around.at(movement.span)
        self._inner = begin(movement.body, dice, around, start)
        body = movement.body
        self._left: Duration = ENDLESS if body.open else (body.duration - start) / around.rate

    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        if self._inner and self._condition.holds(sensed):
            whole = to_next_whole(beat)
            self._inner = None
            self._stands = whole if isinstance(self._left, float) else min(whole, self._left)
            return Decision(self._source, beat, True)
        return super().read(sensed, beat)

    def pass_time(self, beats: Exact) -> None:
        self._left -= beats
        super().pass_time(beats)

    def watched(self) -> Iterator[str]:
        if self._inner:
            yield self._condition.sense
            yield from self._inner.watched()


class _Pause(_Through):
    """A `pause`: while its condition holds, the robot stands still, beat by beat, and then continues from there."""

    def __init__(self, movement: Pause, dice: Dice | None, around: Around, start: Duration) -> None:
        self._condition = movement.condition
        self._source = around.at(movement.span)
        self._inner = begin(movement.body, dice, around, start if movement.wanted else 0)
        if not movement.wanted and not isinstance(start, float):  # it has not moved at all
            self._stands = -(start / around.rate) % 1

    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        if not self._stands and self._condition.holds(sensed):
            self._stands = 1
            return Decision(self._source, beat, True)
        return super().read(sensed, beat)

    def watched(self) -> Iterator[str]:
        yield self._condition.sense
        yield from super().watched()


class _If(_Through):
    """An `if`: its condition decides, when it begins, which of two movements is performed."""

    def __init__(self, movement: If, dice: Dice | None, around: Around, start: Duration) -> None:
        self._if = movement
        self._dice = dice
        self._around = around
        self._inner = begin(*movement.side(not movement.wanted, dice), around, start) if start else None

    def is_over(self, beat: Exact) -> bool:
        return self._inner is not None and self._inner.is_over(beat)

    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        if self._inner:
            return self._inner.read(sensed, beat)
        holds = self._if.condition.holds(sensed)
        self._inner = begin(*self._if.side(holds, self._dice), self._around)
        return Decision(self._around.at(self._if.span), beat, holds)


def to_next_whole(beat: Exact) -> Exact:
    """Return the beats from a beat to the next whole one, which is later."""
    return math.floor(beat) + 1 - beat


_KINDS: Mapping[str, Callable[..., Execution]] = {
    Repeat.NAME: _Rounds,
    Parallel.NAME: _Together,
    Until.NAME: _Until,
    Pause.NAME: _Pause,
    If.NAME: _If,
}
