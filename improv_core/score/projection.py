"""The movement of one body part within a movement, as a movement like any other. Standard library only."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple, Protocol

from improv_core.score.algebra import STANDING, FromStatement, Gain, Hold, from_statement, hold, stand
from improv_core.score.body import START, Body
from improv_core.score.bounds import held, swaps_sides
from improv_core.score.by_part import ByPart, ToPose
from improv_core.score.movement import Duration, Exact, Factors, Movement, Through, Velocity, Visit, exact
from improv_core.score.reactions import Reaction
from improv_core.score.throws import Dice
from improv_core.score.traversal import inner_first
from improv_core.text import Span
from improv_core.values import value

BASE = ""
FINEST_STEP = 10**12
"""Positions of joints are rounded to this many parts of a step when a pose is reached from them."""


class Posture(Protocol):
    """The positions of a part's joints now, which its performer updates before it asks for the next moment."""

    def steps(self, direction: str) -> float:
        """Return the steps of a direction's joint from its zero."""
        ...


@value(frozen=True, slots=True, eq=False)
class Reach(Through):
    """A movement to a pose from the positions of joints when it begins, which decide its velocity.

    `goal` has a number of steps for each direction that moves. It is `mirrored` if its surroundings negate its velocity
    to the left.
    """

    goal: Velocity
    moved: tuple[str, ...]
    mirrored: bool
    posture: Posture
    span: Span | None

    NAME = "reach"

    def inner(self, at: Duration, backward: bool, dice: Dice | None) -> Visit:
        left = Fraction(1) if backward or isinstance(at, float) else Fraction(1 - at)
        way = {each: (getattr(self.goal, each) - _exact(self.posture.steps(each))) / left for each in self.moved}
        velocity = Velocity(**{each: exact(Fraction(value)) for each, value in way.items()})
        return Visit(hold(velocity.times(_MIRROR) if self.mirrored else velocity, 1, self.span), at, backward, dice)


class _Under(NamedTuple):
    """The surroundings of a part of a movement: whether our body part performs it, and whether there is an odd number
    of reflections that swap sides, in all and outside the word for the body part."""

    mine: bool
    flipped: bool = False
    flipped_outside: bool = False


_MIRROR = Factors(y=-1, yaw=-1)
_At = tuple[Movement, _Under]


def project(whole: Movement, part: str, body: Body, posture: Posture) -> Movement:
    """Return the movement of one body part. It has the length, dice, and senses of the whole.

    It rests while other parts move. What needs no body part is shared, and rests are as short as they can be. `BASE` is
    the base.
    """
    begin = (whole, _Under(part == BASE))
    made: dict[tuple[int, _Under], Movement] = {}
    for each, under in inner_first(begin, lambda at: _inside(at, part, body), _key):
        inner = [made[_key(at)] for at in _inside((each, under), part, body)]
        made[id(each), under] = _projected(each, under, inner, part, body, posture)
    return made[_key(begin)]


def _key(at: _At) -> tuple[int, _Under]:
    return id(at[0]), at[1]


def _inside(at: _At, part: str, body: Body) -> list[_At]:
    """Return the parts to project before a part of a movement."""
    whole, under = at
    if not whole.body_words.asked and (under.mine or not (whole.dice or whole.open)):
        return []
    if isinstance(whole, ByPart):
        mine = part in body.performers(whole.part, under.flipped)
        return [(whole.body, _Under(mine, under.flipped, under.flipped))]
    if isinstance(whole, Gain) and swaps_sides(whole.gain):
        return [(whole.body, under._replace(flipped=not under.flipped))]
    assumed = (whole.assumed,) if isinstance(whole, Reaction) else ()
    return [(each, under) for each in (*whole.parts, *assumed)]


def _projected(
    whole: Movement, under: _Under, inner: list[Movement], part: str, body: Body, posture: Posture
) -> Movement:
    if isinstance(whole, ToPose):
        return _reach(whole, under, part, body, posture) if under.mine else stand(1)
    if not whole.body_words.asked:
        if under.mine:
            return whole
        if not (whole.dice or whole.open):
            return _rest(whole.duration)
        if isinstance(whole, Hold):
            return _rest(whole.duration)
    if isinstance(whole, ByPart):
        return inner[0]
    if isinstance(whole, FromStatement) and not under.mine and not whole.body_words.asked:
        return from_statement(inner[0], None, whole.statement)  # a rest isn't highlighted
    if isinstance(whole, Reaction):  # pictures and checks may assume something else than `made_of` does
        *items, assumed = inner
        made = whole.made_of(items)
        assert isinstance(made, Reaction)
        return replace(made, assumed=assumed, duration=assumed.duration)
    return whole.made_of(inner)


def base_of(whole: Movement) -> Movement:
    """Return the movement of the base, with rests in place of the words that body parts perform."""
    return project(whole, BASE, Body(), _Nowhere()) if whole.body_words.asked else whole


class _Nowhere:
    def steps(self, direction: str) -> float:
        return 0.0


def _rest(duration: Duration) -> Movement:
    return STANDING if isinstance(duration, float) else stand(duration)


def _reach(word: ToPose, under: _Under, part: str, body: Body, posture: Posture) -> Movement:
    """Return a pose as this part reaches it: reflections negate it unless they exchange parts, or it is the start."""
    if part == BASE or not body.part[part].has_pose(word.pose):
        return stand(1)
    goal = dict(goal_of(part, word.pose, body))
    exchanges = body.part[part].mirror is not None
    if word.pose != START and under.flipped != (exchanges and under.flipped_outside):
        goal = {name: -value if getattr(_MIRROR, name) < 0 else value for name, value in goal.items()}
    steps = Velocity(**{name: _exact(value) for name, value in goal.items()})
    bounds = held(0.0, 0.0, 0.0, 0.0, 1.0)
    return Reach(1, None, bounds, steps, tuple(goal), under.flipped, posture, word.span)


def goal_of(part: str, pose: str, body: Body) -> Iterator[tuple[str, float]]:
    """Yield the directions of a part that a pose moves, and their targets in steps."""
    found = body.part[part].pose(pose)
    for drive in body.part[part].drives:
        if pose == START:
            yield drive.direction, body.joint[drive.joint].start / drive.per_step
        elif found and drive.direction in found.steps:
            yield drive.direction, found.steps[drive.direction]


def _exact(steps: float) -> Exact:
    return exact(Fraction(round(steps * FINEST_STEP), FINEST_STEP))
