"""Assumptions of pictures and checks about open movements, since nothing is sensed there. Standard library only."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import islice

from improv_core.score.algebra import parallel, series, stand
from improv_core.score.movement import ENDLESS, Duration, Movement
from improv_core.score.reactions import Reaction, Until
from improv_core.score.traversal import inner_first
from improv_core.score.walk import walk

PICTURED_BEATS = 4
"""Beats after which an `until` of an endless movement is pictured as over."""
CHECKED_BEATS = 64
"""The number of beats that are checked of an endless movement that senses may end."""
_Supposing = Callable[[Reaction, Sequence[Movement]], Movement]


def as_pictured(movement: Movement) -> Movement:
    """Return the movement as it is pictured: no sense ever holds, and an `until` of an endless movement still ends."""
    return _supposed(movement, _ending)


def as_passed(movement: Movement) -> Movement:
    """The movement as it is pictured, except that robots that would wait forever continue, and all after it begins."""
    return _supposed(
        movement, lambda reaction, items: items[0] if _waits_forever(reaction) else _ending(reaction, items)
    )


def with_all_sides(movement: Movement) -> Movement:
    """The movement with all that senses may make of it: each `until` to its end, both sides of each `if`."""
    return _supposed(movement, lambda reaction, items: series([_cut(item, CHECKED_BEATS) for item in items]))


def certain_beats(movement: Movement, pictured: Movement, most: int) -> Duration:
    """Return the beats for which a movement plays as it is pictured if no sense holds; `most` moments are compared."""
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


def _waits_forever(reaction: Reaction) -> bool:
    """Return whether the picture shows a robot that waits forever."""
    return reaction.assumed.duration == ENDLESS and all(own is not reaction.assumed for own in reaction.items)


def _cut(movement: Movement, beats: int) -> Movement:
    return parallel([movement, stand(beats)]) if movement.duration == ENDLESS else movement


def _supposed(whole: Movement, suppose: _Supposing) -> Movement:
    """Return the movement with another assumption for each reaction."""
    made: dict[int, Movement] = {}
    for part in inner_first(whole, lambda part: [each for each in part.parts if each.open]):
        items = [made.get(id(each), each) for each in part.parts]
        if isinstance(part, Reaction):
            assumed = suppose(part, items)
            made[id(part)] = replace(part, items=tuple(items), assumed=assumed, duration=assumed.duration)
        else:
            made[id(part)] = part.made_of(items) if part.open else part
    return made[id(whole)]
