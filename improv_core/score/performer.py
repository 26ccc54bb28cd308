"""Performs an open movement, one whose moments depend on what its robot senses. Standard library only.

A closed movement is walked ahead (walk.py). An open one can't be: a performer is told what is sensed as time passes,
and knows what the robot does until the next change that is certain. It never reads a clock.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from itertools import chain, count
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
    all_by,
)
from improv_core.score.reactions import If, Pause, Until
from improv_core.score.throws import ROBOTS, Dice, dice_of
from improv_core.score.walk import walk

Sensed = Callable[[str], bool | None]
"""Whether a sense is true at this moment; None if that is not known: then no condition about it holds."""


Performed = tuple[Velocity, tuple[Source, ...]]
"""A velocity, and the words that play."""


class Performer:
    """The performance of a movement that begins at a beat, for one robot. Beats are those of the performance.

    Call `settle` when something may have changed, then ask, then `advance`.
    """

    def __init__(self, movement: Movement, beat: Exact = 0) -> None:
        self._act = _act(movement, dice_of(ROBOTS) if movement.dice else None, Around())
        self.beat = beat
        """The beat up to which it has been performed."""

    def settle(self, sensed: Sensed) -> list[Decision]:
        """Do all that takes no time: begin what begins now, and read the senses that are watched now."""
        decisions = []
        while not self._act.is_over(self.beat) and (decision := self._act.read(sensed, self.beat)):
            decisions.append(decision)
        return decisions

    @property
    def is_over(self) -> bool:
        """Whether nothing is left to perform."""
        return self._act.is_over(self.beat)

    @property
    def until(self) -> Duration:
        """The beat of the next change, if what is sensed does not change before."""
        return self.beat + self._act.left()

    def velocity(self) -> Performed:
        """What is performed until then."""
        return self._act.velocity()

    def watched(self) -> frozenset[str]:
        """The senses that may change that."""
        return frozenset(self._act.watched())

    def advance(self, beat: Exact) -> None:
        """Perform up to a beat, `until` at the latest."""
        if passed := beat - self.beat:
            self._act.pass_time(passed)
            self.beat = beat


class Decision(NamedTuple):
    """What a word of senses has decided at a beat: whether its condition held. `sources` ends with that word."""

    sources: tuple[Source, ...]
    beat: Exact
    held: bool


class _Act(ABC):
    """A movement in performance. Times are beats of the performance, apart from those in which it is frozen."""

    @abstractmethod
    def is_over(self, beat: Exact) -> bool:
        """Whether no time is left. Begins what begins now, and reads no sense: an undecided `if` is not over."""

    @abstractmethod
    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        """Read senses, outermost first, up to the first that decides something. For acts that are not over."""

    @abstractmethod
    def left(self) -> Duration:
        """The beats until the next change that is certain."""

    @abstractmethod
    def velocity(self) -> Performed: ...

    @abstractmethod
    def pass_time(self, beats: Exact) -> None: ...

    @abstractmethod
    def watched(self) -> Iterator[str]: ...


def _act(movement: Movement, dice: Dice | None, around: Around) -> _Act:
    """The act of a movement, with its dice and what surrounds it. What is closed is walked as a whole."""
    while movement.open:
        if act := _ACTS.get(movement.NAME):
            return act(movement, dice, around)
        around = movement.within(around)
        if isinstance(movement, InTurn):
            return _Sequence(_act(part, own, around) for part, _, _, own in movement.visits(0, False, dice))
        assert isinstance(movement, Through)
        movement, _, _, dice = movement.inner(0, False, dice)
    return _Closed(movement, dice, around)


class _Closed(_Act):
    """A closed movement. It reads nothing."""

    def __init__(self, movement: Movement, dice: Dice | None, around: Around) -> None:
        self._around = around
        self._moments = walk(movement, dice=dice, statement=around.statement)
        self._left: Duration = 0
        self._performed: Performed | None = None
        self._next()

    def is_over(self, beat: Exact) -> bool:
        return self._performed is None

    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        return None

    def left(self) -> Duration:
        return self._left

    def velocity(self) -> Performed:
        assert self._performed
        return self._performed

    def pass_time(self, beats: Exact) -> None:
        self._left -= beats
        if not self._left:
            self._next()

    def watched(self) -> Iterator[str]:
        return iter(())

    def _next(self) -> None:
        moment, around = next(self._moments, None), self._around
        if moment:
            self._left = moment.duration / around.rate
            velocity = moment.velocity.times(around.gain).times(all_by(around.rate))
            self._performed = velocity, around.sources + moment.sources
        else:
            self._performed = None


class _Through(_Act):
    """An act that performs one other at a time: `_act`."""

    _act: _Act | None

    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        assert self._act
        return self._act.read(sensed, beat)

    def left(self) -> Duration:
        assert self._act
        return self._act.left()

    def velocity(self) -> Performed:
        assert self._act
        return self._act.velocity()

    def pass_time(self, beats: Exact) -> None:
        assert self._act
        self._act.pass_time(beats)

    def watched(self) -> Iterator[str]:
        assert self._act
        return self._act.watched()


class _Sequence(_Through):
    """Movements one after another. Each begins when the one before it is over."""

    def __init__(self, items: Iterator[_Act]) -> None:
        self._items = items
        self._act = next(items, None)

    def is_over(self, beat: Exact) -> bool:
        while self._act and self._act.is_over(beat):
            self._act = next(self._items, None)
        return self._act is None


class _Rounds(_Act):
    """A repeat. A round that takes no time ends it or, if it is endless, makes it stand until the next whole beat."""

    def __init__(self, movement: Repeat, dice: Dice | None, around: Around) -> None:
        self._endless = movement.times is None
        self._rounds = _rounds(movement, dice, around)
        self._round = next(self._rounds, None)
        self._took: Exact = 0
        self._stands: Exact = 0

    def is_over(self, beat: Exact) -> bool:
        while not self._stands and self._round and self._round.is_over(beat):
            if self._took or not self._endless:
                self._round = next(self._rounds, None) if self._took else None
            else:
                self._round, self._stands = next(self._rounds), to_next_whole(beat)
            self._took = 0
        return self._round is None

    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        assert self._round
        return None if self._stands else self._round.read(sensed, beat)

    def left(self) -> Duration:
        assert self._round
        return self._stands or self._round.left()

    def velocity(self) -> Performed:
        assert self._round
        return (STILL, ()) if self._stands else self._round.velocity()

    def pass_time(self, beats: Exact) -> None:
        assert self._round
        if self._stands:
            self._stands -= beats
        else:
            self._took += beats
            self._round.pass_time(beats)

    def watched(self) -> Iterator[str]:
        assert self._round
        return iter(()) if self._stands else self._round.watched()


def _rounds(movement: Repeat, dice: Dice | None, around: Around) -> Iterator[_Act]:
    for turn in count() if movement.times is None else range(movement.times):
        yield _act(movement.body, dice and movement.dice_at(turn, dice), around)


class _Together(_Act):
    """Voices at once. The first that is over ends all, except that a voice that is empty when it begins is ignored."""

    def __init__(self, movement: Parallel, dice: Dice | None, around: Around) -> None:
        dice = dice if movement.dice else None
        self._voices = [_act(voice, dice and dice.inside(index), around) for index, voice in enumerate(movement.items)]
        self._begins = True

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


class _Until(_Act):
    """An `until`: as soon as its condition holds, the robot stands until the next whole beat, or until it would end."""

    def __init__(self, movement: Until, dice: Dice | None, around: Around) -> None:
        self._until = movement
        self._source = around.at(movement.span)
        self._act = _act(movement.body, dice, around)
        self._stands: Exact | None = None
        body = movement.body
        self._left: Duration = ENDLESS if body.open else body.duration / around.rate

    def is_over(self, beat: Exact) -> bool:
        return self._act.is_over(beat) if self._stands is None else not self._stands

    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        if self._stands is not None:
            return None
        if self._until.condition.holds(sensed):
            whole = to_next_whole(beat)
            self._stands = whole if isinstance(self._left, float) else min(whole, self._left)
            return Decision(self._source, beat, True)
        return self._act.read(sensed, beat)

    def left(self) -> Duration:
        return self._act.left() if self._stands is None else self._stands

    def velocity(self) -> Performed:
        return self._act.velocity() if self._stands is None else (STILL, self._source)

    def pass_time(self, beats: Exact) -> None:
        if self._stands is None:
            self._act.pass_time(beats)
            self._left -= beats
        else:
            self._stands -= beats

    def watched(self) -> Iterator[str]:
        if self._stands is None:
            yield self._until.condition.sense
            yield from self._act.watched()


class _Pause(_Act):
    """A `pause`: while its condition holds, the robot stands still, beat by beat, and then continues from there."""

    def __init__(self, movement: Pause, dice: Dice | None, around: Around) -> None:
        self._pause = movement
        self._source = around.at(movement.span)
        self._act = _act(movement.body, dice, around)
        self._stands: Exact = 0

    def is_over(self, beat: Exact) -> bool:
        return not self._stands and self._act.is_over(beat)

    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        if self._stands:
            return None
        if self._pause.condition.holds(sensed):
            self._stands = 1
            return Decision(self._source, beat, True)
        return self._act.read(sensed, beat)

    def left(self) -> Duration:
        return self._stands or self._act.left()

    def velocity(self) -> Performed:
        return (STILL, self._source) if self._stands else self._act.velocity()

    def pass_time(self, beats: Exact) -> None:
        if self._stands:
            self._stands -= beats
        else:
            self._act.pass_time(beats)

    def watched(self) -> Iterator[str]:
        yield self._pause.condition.sense
        if not self._stands:
            yield from self._act.watched()


class _If(_Through):
    """An `if`: its condition decides, when it begins, which of two movements is performed."""

    def __init__(self, movement: If, dice: Dice | None, around: Around) -> None:
        self._if = movement
        self._dice = dice
        self._around = around
        self._act = None

    def is_over(self, beat: Exact) -> bool:
        return self._act is not None and self._act.is_over(beat)

    def read(self, sensed: Sensed, beat: Exact) -> Decision | None:
        if self._act:
            return super().read(sensed, beat)
        holds = self._if.condition.holds(sensed)
        self._act = _act(*self._if.side(holds, self._dice), self._around)
        return Decision(self._around.at(self._if.span), beat, holds)


def to_next_whole(beat: Exact) -> Exact:
    """The beats from a beat to the next whole one, which is later."""
    return math.floor(beat) + 1 - beat


_ACTS: Mapping[str, Callable[..., _Act]] = {
    Repeat.NAME: _Rounds,
    Parallel.NAME: _Together,
    Until.NAME: _Until,
    Pause.NAME: _Pause,
    If.NAME: _If,
}
