"""What pictures and checks assume of open movements, since nothing is sensed there. Standard library only."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import islice

from improv_core.score import movement as algebra
from improv_core.score.dice import (
    Chance,
    Choose,
    Seed,
    Shuffle,
    Throwing,
    chance,
    choose,
    seed,
    shuffle,
    throwing,
)
from improv_core.score.inner_first import inner_first
from improv_core.score.movement import ENDLESS, Duration, Movement, parallel, series, stand
from improv_core.score.reactions import Reaction, Until
from improv_core.score.walk import walk

PICTURED_BEATS = 4
"""An `until` of an endless movement is pictured as if it were over after so many beats."""
CHECKED_BEATS = 64
"""How many beats are checked of an endless movement that senses may end."""
_Supposing = Callable[[Reaction, Sequence[Movement]], Movement]


def as_pictured(movement: Movement) -> Movement:
    """The movement as it is pictured: no sense ever holds, and an `until` of an endless movement ends all the same."""
    return _supposed(movement, _ending)


def with_all_sides(movement: Movement) -> Movement:
    """The movement with all that senses may make of it: each `until` to its end, both sides of each `if`."""
    return _supposed(movement, lambda reaction, items: series([_cut(item, CHECKED_BEATS) for item in items]))


def certain_beats(movement: Movement, pictured: Movement, most: int) -> Duration:
    """The beats for which a movement is performed as it is pictured if no sense holds; `most` moments are compared."""
    moments = zip(walk(movement), walk(pictured), strict=False)
    for one, other in islice(moments if movement.open else (), most):
        if one.velocity != other.velocity:
            return one.start
        if one.duration != other.duration:
            return one.start + min(one.duration, other.duration)
    return ENDLESS


def _ending(reaction: Reaction, items: Sequence[Movement]) -> Movement:
    assumed = next((item for item, own in zip(items, reaction.items, strict=True) if own is reaction.assumed), None)
    if assumed is None:
        return reaction.assumed  # it stands still
    return _cut(assumed, PICTURED_BEATS) if isinstance(reaction, Until) else assumed


def _cut(movement: Movement, beats: int) -> Movement:
    """The first beats of a movement that never ends."""
    return parallel([movement, stand(beats)]) if movement.duration == ENDLESS else movement


def _supposed(whole: Movement, suppose: _Supposing) -> Movement:
    """The movement with something else assumed for each reaction."""
    made: dict[int, Movement] = {}
    for part in inner_first(whole, lambda part: [each for each in algebra.parts(part) if each.open]):
        items = [made.get(id(each), each) for each in algebra.parts(part)]
        if isinstance(part, Reaction):
            assumed = suppose(part, items)
            made[id(part)] = replace(part, items=tuple(items), assumed=assumed, duration=assumed.duration)
        else:
            made[id(part)] = remade(part, items) if part.open else part
    return made[id(whole)]


def remade(part: Movement, items: Sequence[Movement]) -> Movement:
    """A movement made again from other parts. Not for reactions and ramps."""
    if isinstance(part, algebra.Series):
        return series(items)
    if isinstance(part, algebra.Parallel):
        return parallel(items)
    if isinstance(part, Shuffle):
        return shuffle(items)
    if isinstance(part, Choose):
        return choose(items)
    (body,) = items
    if isinstance(part, algebra.Repeat):
        return algebra.repeat(body, part.times)
    if isinstance(part, algebra.Pace):
        return algebra.pace(body, part.rate)
    if isinstance(part, algebra.Gain):
        return algebra.gain(body, part.gain)
    if isinstance(part, algebra.Reverse):
        return algebra.reverse(body)
    if isinstance(part, Chance):
        return chance(body, part.probability, part.span)
    if isinstance(part, Seed):
        return seed(body, part.number)
    if isinstance(part, Throwing):
        return throwing(body, part.throw, part.stream)
    assert isinstance(part, algebra.Use)
    return algebra.use(body, part.span, part.statement)
