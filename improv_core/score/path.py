"""The path of a movement: its length, its turns, and where it ends. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from typing import NamedTuple

from improv_core.score.algebra import Hold, Parallel, Repeat, reverse
from improv_core.score.inner_first import inner_first
from improv_core.score.motion import Pose
from improv_core.score.movement import (
    ENDLESS,
    NOTHING_AROUND,
    SAME,
    Duration,
    Exact,
    InTurn,
    Movement,
    Piecewise,
    Through,
    Velocity,
    Visit,
)
from improv_core.score.profiles import Profile
from improv_core.score.reactions import Reaction
from improv_core.score.score import Part, twist
from improv_core.score.throws import ROBOTS, Dice, dice_of
from improv_core.score.walk import walk

MOST_MOMENTS = 10_000
"""Parallel voices are walked to measure them. If they have more moments than this, the result is unknown."""
MOST_WALKED = 2_000
"""The same limit for the pose where they end, which is computed while robots play."""
MOST_MEASURED_THROWS = 100_000
"""The most throws that are looked at: the turns of a repeat with dice differ, so they can't be multiplied."""
MOST_MEASURED_LIVE = 10_000
"""The same limit for a pose, which is computed while robots play."""
VISITS_PER_THROW = 5
"""How many parts may be visited for each of these throws."""
A_BEAT_A_SECOND = Fraction(60)
"""A tempo at which beats are seconds. A path does not depend on the tempo."""


@dataclass(frozen=True, slots=True)
class Extent:
    """The length of a path in steps, and its total turn in quarter turns, positive to the left."""

    steps: float
    turns: float


class _TooLongError(Exception):
    """A movement is too long to measure."""


@dataclass(slots=True)
class _Budget:
    """How many parts may still be visited."""

    left: int

    def spend(self, visits: int) -> None:
        self.left -= visits
        if self.left < 0:
            raise _TooLongError

    def allow(self, throws: int) -> None:
        """Give up at once if so many throws cost too much."""
        if throws * VISITS_PER_THROW > self.left:
            raise _TooLongError


class _Leg(NamedTuple):
    """A part of a movement as it plays: with its velocities multiplied, perhaps backward, and with its dice if any."""

    movement: Movement
    gain: Velocity
    backward: bool
    dice: Dice | None

    @classmethod
    def first(cls, movement: Movement) -> _Leg:
        return cls(movement, SAME, False, dice_of(ROBOTS) if movement.dice else None)

    def to(self, visit: Visit) -> _Leg:
        """The leg of a part that plays in place of this one."""
        part, _, backward, dice = visit
        around = self.movement.within(NOTHING_AROUND)
        gain = self.gain if around is NOTHING_AROUND else self.gain.times(around.gain)
        return _Leg(part, gain, backward, dice if part.dice else None)

    @property
    def is_walked(self) -> bool:
        """Whether it is measured as a whole."""
        return self.movement.uniform is not None or isinstance(self.movement, Parallel)


def extent(movement: Movement, most: int = MOST_MOMENTS) -> Extent | None:
    """The extent of a movement; None if it is endless, has voices with more moments than `most`, or too many dice.

    Repeats without dice are multiplied, not walked. Inner movements are measured first, without recursion.
    """
    if movement.duration == ENDLESS:
        return None
    known: dict[int, Extent] = {}
    steps, turns = [], []
    budget = _Budget(MOST_MEASURED_THROWS * VISITS_PER_THROW)
    try:
        for leg in _decided(_Leg.first(movement), budget):
            each = _walked(leg, budget) if leg.dice else _extent(leg.movement, known, most)
            steps.append(each.steps * float(abs(leg.gain.x)))
            turns.append(each.turns * float(leg.gain.yaw))
    except _TooLongError:
        return None
    return Extent(math.fsum(steps), math.fsum(turns))


def _extent(movement: Movement, known: dict[int, Extent], most: int) -> Extent:
    """The extent of a movement without dice."""
    if found := known.get(id(movement)):
        return found

    for part in inner_first(movement, lambda part: [each for each in _measured(part) if id(each) not in known]):
        if isinstance(part, (Hold, Parallel)):
            known[id(part)] = _walked(_Leg.first(part), _Budget(most))
            continue
        inner = [known[id(each)] for each in _measured(part)]
        gain = part.within(NOTHING_AROUND).gain
        times = (part.times or 0) if isinstance(part, Repeat) else 1
        steps, turns = math.fsum(each.steps for each in inner), math.fsum(each.turns for each in inner)
        known[id(part)] = Extent(steps * float(abs(gain.x)) * times, turns * float(gain.yaw) * times)
    return known[id(movement)]


def _measured(part: Movement) -> Sequence[Movement]:
    """The movements that are measured to measure one without dice. Voices are measured together."""
    if isinstance(part, Parallel):
        return ()
    return (part.assumed,) if isinstance(part, Reaction) else part.parts


def _walked(leg: _Leg, budget: _Budget) -> Extent:
    steps, turns = [], []
    for moment in walk(leg.movement, merge=True, dice=leg.dice):
        budget.spend(1)
        x, y, z, yaw = (float(value * moment.duration) for value in moment.velocity)
        steps.append(math.hypot(x, y, z))
        turns.append(yaw)
    return Extent(math.fsum(steps), math.fsum(turns))


def pose_at(part: Part, beat: Exact, most_throws: int = MOST_MEASURED_LIVE) -> Pose | None:
    """A robot's ideal pose at a beat of the performance; None if voices are too long to walk, or throws too many.

    Repeats without dice are multiplied, not walked: the billionth repetition costs no more than the second.
    """
    passed = min(max(beat - part.begins, 0), part.movement.duration)
    budget = _Budget(most_throws * VISITS_PER_THROW)
    try:
        return (part.entered or part.start).then(_displacement(_Leg.first(part.movement), passed, part.profile, budget))
    except _TooLongError:
        return None


def _displacement(leg: _Leg, until: Duration, profile: Profile, budget: _Budget) -> Pose:
    """How the first `until` beats of a leg move a robot, as a pose relative to its start."""
    known: dict[tuple[int, Velocity, bool], Pose] = {}
    moved = Pose()
    while until < leg.movement.duration and not leg.is_walked:
        before, leg, until = _split(leg, until, budget)
        for each, times in before:
            moved = moved.then(_times(_whole(each, profile, known, budget), times))
    if until < leg.movement.duration:
        return moved.then(_walked_displacement(leg, until, profile, budget if leg.dice else None))
    return moved.then(_whole(leg, profile, known, budget))


def _split(leg: _Leg, until: Duration, budget: _Budget) -> tuple[Iterable[tuple[_Leg, int]], _Leg, Duration]:
    """The inner legs that finish within `until` beats and how often; the one that doesn't, and how far it gets."""
    part, _, backward, dice = leg
    at = part.duration - until if backward else until
    if isinstance(part, Through):
        visit = part.inner(at, backward, dice)
        return (), leg.to(visit), visit.part.duration - visit.at if visit.backward else visit.at
    if isinstance(part, Repeat) and part.body.duration != ENDLESS:
        turns = int(until // part.body.duration)
        inner = leg.to(next(part.visits(at, backward, dice)))
        done = [(inner, turns)]
        if dice:
            budget.allow(turns * part.body.throws)
            done = [(each, 1) for each in islice(_inside(leg), turns)]
        return done, inner, until % part.body.duration
    done = []
    for inner in _inside(leg):
        if until < inner.movement.duration:
            break
        done.append((inner, 1))
        until -= inner.movement.duration
    budget.allow(sum(each.movement.throws for each, _ in done))
    return done, inner, until


def _whole(leg: _Leg, profile: Profile, known: dict[tuple[int, Velocity, bool], Pose], budget: _Budget) -> Pose:
    """How a whole leg moves a robot."""
    moved = Pose()
    for each in _decided(leg, budget):
        if each.dice:
            moved = moved.then(_walked_displacement(each, each.movement.duration, profile, budget))
        else:
            moved = moved.then(_whole_without_dice(each, profile, known))
    return moved


def _whole_without_dice(leg: _Leg, profile: Profile, known: dict[tuple[int, Velocity, bool], Pose]) -> Pose:
    if found := known.get(_key(leg)):
        return found

    def inside(leg: _Leg) -> Iterable[_Leg]:
        return () if leg.is_walked else [each for each in _inside(leg) if _key(each) not in known]

    for now in inner_first(leg, inside, _key):
        if now.is_walked:
            known[_key(now)] = _walked_displacement(now, now.movement.duration, profile)
            continue
        moved = Pose()
        for each in _inside(now):
            moved = moved.then(known[_key(each)])
        known[_key(now)] = _times(moved, now.movement.times or 0) if isinstance(now.movement, Repeat) else moved
    return known[_key(leg)]


def _key(leg: _Leg) -> tuple[int, Velocity, bool]:
    return id(leg.movement), leg.gain, leg.backward


def _decided(leg: _Leg, budget: _Budget) -> Iterator[_Leg]:
    """A leg as a series of legs without dice, and of voices with dice."""
    stack = [iter((leg,))]
    while stack:
        each = next(stack[-1], None)
        if each is None:
            stack.pop()
        elif each.dice is None or each.is_walked:
            yield each
        elif each.movement.duration:  # an endless repeat of nothing is over at once
            budget.allow(each.movement.throws)
            budget.spend(1)
            stack.append(_inside(each))


def _inside(leg: _Leg) -> Iterator[_Leg]:
    """The inner legs in the order they play; the body of a repeat without dice only once."""
    part, gain, backward, dice = leg
    at = part.duration if backward else 0
    if isinstance(part, Through):
        yield leg.to(part.inner(at, backward, dice))
    elif isinstance(part, Repeat) and not dice:
        yield _Leg(part.body, gain, backward, None)
    else:
        assert isinstance(part, InTurn)
        for each, _, _, own in part.visits(at, backward, dice):
            yield _Leg(each, gain, backward, own if each.dice else None)


def _walked_displacement(leg: _Leg, until: Duration, profile: Profile, budget: _Budget | None = None) -> Pose:
    """How the first `until` beats of a leg of constant velocity or of voices move a robot."""
    if leg.movement.uniform is not None:
        moving = twist(leg.movement.uniform.times(leg.gain), profile, A_BEAT_A_SECOND)
        return Pose().after(moving, float(until))
    period = _period(leg.movement)
    if period and until > period:
        turns, rest = divmod(until, period)
        once, last = (_walked_displacement(leg, beats, profile, budget) for beats in (period, rest))
        return _times(once, int(turns)).then(last)
    movement = reverse(leg.movement) if leg.backward else leg.movement
    budget = budget or _Budget(MOST_WALKED)
    moved = Pose()
    for moment in walk(movement, merge=True, dice=leg.dice):
        left = until - moment.start
        if left <= 0:
            break
        budget.spend(1)
        velocity = moment.velocity.times(leg.gain)
        moving = twist(velocity, profile, A_BEAT_A_SECOND)
        moved = moved.after(moving, float(min(moment.duration, left)))
    return moved


def _period(movement: Movement) -> Exact | None:
    """The beats after which all parallel voices are back at their start; None if that never happens.

    0 if the velocity never changes. The period is the same backward.
    """
    if movement.dice or movement.open:
        return None
    rate = Fraction(1)
    while movement.uniform is None and isinstance(movement, Through) and not isinstance(movement, Piecewise):
        rate *= movement.within(NOTHING_AROUND).rate
        (movement,) = movement.parts
    if movement.uniform is not None:
        return 0
    if isinstance(movement, Repeat) and movement.body.duration != ENDLESS:
        return Fraction(movement.body.duration) / rate
    if not isinstance(movement, Parallel):
        return None
    common = Fraction(0)
    for voice in movement.items:
        period = _period(voice)
        if period is None:
            return None
        common = common_multiple(common, Fraction(period)) if period else common
    return common / rate


def common_multiple(one: Fraction, other: Fraction) -> Fraction:
    """The least common multiple; 0 is ignored."""
    if not one:
        return other
    return Fraction(math.lcm(one.numerator, other.numerator), math.gcd(one.denominator, other.denominator))


def _times(moved: Pose, times: int) -> Pose:
    """The pose after a path is repeated `times` times, computed by repeated squaring."""
    gone = Pose()
    while times:
        if times % 2:
            gone = gone.then(moved)
        moved, times = moved.then(moved), times // 2
    return gone
