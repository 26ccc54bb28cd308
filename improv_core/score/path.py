"""The path of a movement: its length, its turns, and where it ends. Standard library only."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from typing import NamedTuple

from improv_core.score import movement as algebra
from improv_core.score.motion import Pose
from improv_core.score.movement import ENDLESS, SAME, Duration, Exact, Movement, Velocity
from improv_core.score.profiles import Profile
from improv_core.score.score import Part, twist
from improv_core.score.walk import walk

MOST_MOMENTS = 10_000
"""Parallel voices are walked to measure them. If they have more moments than this, the result is unknown."""
MOST_WALKED = 2_000
"""The same limit for the pose where they end, which is computed while robots play."""
A_BEAT_A_SECOND = Fraction(60)
"""A tempo at which beats are seconds. A path does not depend on the tempo."""


@dataclass(frozen=True, slots=True)
class Extent:
    """The length of a path in steps, and its total turn in quarter turns, positive to the left."""

    steps: float
    turns: float


def extent(movement: Movement, most: int = MOST_MOMENTS) -> Extent | None:
    """The extent of a movement; None if it is endless or has voices with more moments than `most`.

    Repeats are multiplied, not walked. Inner movements are measured first, without recursion.
    """
    if movement.duration == ENDLESS:
        return None
    known: dict[int, Extent | None] = {}
    waiting = [movement]
    while waiting:
        part = waiting[-1]
        inner = () if isinstance(part, algebra.Parallel) else algebra.parts(part)
        unknown = [child for child in inner if id(child) not in known]
        if unknown:
            waiting += unknown
            continue
        waiting.pop()
        known[id(part)] = _extent(part, [known[id(child)] for child in inner], most)
    return known[id(movement)]


def _extent(part: Movement, inner: list[Extent | None], most: int) -> Extent | None:
    if isinstance(part, (algebra.Hold, algebra.Parallel)):
        return _walked(part, most)
    known = [each for each in inner if each]
    if len(known) < len(inner):
        return None
    steps, turns = math.fsum(each.steps for each in known), math.fsum(each.turns for each in known)
    if isinstance(part, algebra.Repeat):
        return Extent(steps * (part.times or 0), turns * (part.times or 0))
    if isinstance(part, algebra.Gain):
        # In this language, all components of a gain have the same absolute value, so it scales every length equally.
        return Extent(steps * float(abs(part.gain.x)), turns * float(part.gain.yaw))
    return Extent(steps, turns)


def _walked(part: Movement, most: int) -> Extent | None:
    steps, turns = [], []
    for count, moment in enumerate(islice(walk(part, merge=True), most + 1)):
        if count == most:
            return None
        x, y, z, yaw = (float(value * moment.duration) for value in moment.velocity)
        steps.append(math.hypot(x, y, z))
        turns.append(yaw)
    return Extent(math.fsum(steps), math.fsum(turns))


def pose_at(part: Part, beat: Exact) -> Pose | None:
    """A robot's ideal pose at a beat of the performance; None if its parallel voices are too long to walk.

    Repeats are multiplied, not walked: the billionth repetition costs no more than the second.
    """
    passed = min(max(beat - part.begins, 0), part.movement.duration)
    gone = _way(_Leg(part.movement, SAME, False), passed, part.profile)
    return None if gone is None else (part.entered or part.start).then(gone)


class _Leg(NamedTuple):
    """A part of a movement as it plays: with its velocities multiplied by `gain`, and perhaps backward."""

    movement: Movement
    gain: Velocity
    backward: bool


def _way(leg: _Leg, until: Duration, profile: Profile) -> Pose | None:
    """How the first `until` beats of a leg move a robot, as a pose relative to its start."""
    known: dict[tuple[int, Velocity, bool], Pose | None] = {}
    way = Pose()
    while True:
        part = leg.movement
        if until >= part.duration:
            rest = _whole(leg, profile, known)
        elif part.uniform is not None or isinstance(part, algebra.Parallel):
            rest = _walked_way(leg, until, profile)
        else:
            before, leg, until = _split(leg, until)
            for other, times in before:
                whole = _whole(other, profile, known)
                if whole is None:
                    return None
                way = way.then(_times(whole, times))
            continue
        return None if rest is None else way.then(rest)


def _split(leg: _Leg, until: Duration) -> tuple[list[tuple[_Leg, int]], _Leg, Duration]:
    """The inner legs that finish within `until` beats and how often; the one that doesn't, and how far it gets."""
    part, gain, backward = leg
    if isinstance(part, algebra.Series):
        done: list[tuple[_Leg, int]] = []
        for item in reversed(part.items) if backward else part.items:
            inner = _Leg(item, gain, backward)
            if until < item.duration:
                return done, inner, until
            done.append((inner, 1))
            until -= item.duration
    if isinstance(part, algebra.Repeat) and part.body.duration != ENDLESS:
        turns, until = divmod(until, part.body.duration)
        inner = _Leg(part.body, gain, backward)
        return [(inner, int(turns))], inner, until
    (inner,) = _inside(leg)
    return [], inner, until * part.rate if isinstance(part, algebra.Pace) else until


def _whole(leg: _Leg, profile: Profile, known: dict[tuple[int, Velocity, bool], Pose | None]) -> Pose | None:
    """How a whole leg moves a robot. Inner legs come first, without recursion."""
    waiting = [leg]
    while waiting:
        part, gain, backward = waiting[-1]
        inner = _inside(waiting[-1])
        unknown = [each for each in inner if (id(each.movement), each.gain, each.backward) not in known]
        if unknown:
            waiting += unknown
            continue
        now = waiting.pop()
        if not inner:
            known[id(part), gain, backward] = _walked_way(now, part.duration, profile)
            continue
        way: Pose | None = Pose()
        for each in inner:
            one = known[id(each.movement), each.gain, each.backward]
            way = way.then(one) if way and one else None
        if way and isinstance(part, algebra.Repeat):
            way = _times(way, part.times or 0)
        known[id(part), gain, backward] = way
    return known[id(leg.movement), leg.gain, leg.backward]


def _inside(leg: _Leg) -> list[_Leg]:
    """The inner legs in the order they play; none if the leg is walked as a whole."""
    part, gain, backward = leg
    if part.uniform is not None or isinstance(part, algebra.Parallel):
        return []
    if isinstance(part, algebra.Gain):
        gain = gain.times(part.gain)
    if isinstance(part, algebra.Reverse):
        backward = not backward
    inner = [_Leg(child, gain, backward) for child in algebra.parts(part)]
    return inner[::-1] if leg.backward else inner


def _walked_way(leg: _Leg, until: Duration, profile: Profile) -> Pose | None:
    if leg.movement.uniform is not None:
        moving = twist(leg.movement.uniform.times(leg.gain), profile, A_BEAT_A_SECOND)
        return Pose().after(moving, float(until))
    period = _period(leg.movement)
    if period and until > period:
        turns, rest = divmod(until, period)
        once, last = _walked_way(leg, period, profile), _walked_way(leg, rest, profile)
        return None if once is None or last is None else _times(once, int(turns)).then(last)
    movement = algebra.reverse(leg.movement) if leg.backward else leg.movement
    way = Pose()
    for walked, moment in enumerate(walk(movement, merge=True)):
        left = until - moment.start
        if left <= 0:
            break
        if walked == MOST_WALKED:
            return None
        velocity = moment.velocity.times(leg.gain)
        moving = twist(velocity, profile, A_BEAT_A_SECOND)
        way = way.after(moving, float(min(moment.duration, left)))
    return way


_SINGLE = (algebra.Use, algebra.Gain, algebra.Pace, algebra.Reverse)


def _period(movement: Movement) -> Exact | None:
    """The beats after which all parallel voices are back at their start; None if that never happens.

    0 if the velocity never changes. The period is the same backward.
    """
    rate = Fraction(1)
    while movement.uniform is None and isinstance(movement, _SINGLE):
        rate *= movement.rate if isinstance(movement, algebra.Pace) else 1
        (movement,) = algebra.parts(movement)
    if movement.uniform is not None:
        return 0
    if isinstance(movement, algebra.Repeat) and movement.body.duration != ENDLESS:
        return Fraction(movement.body.duration) / rate
    if not isinstance(movement, algebra.Parallel):
        return None
    common = Fraction(0)
    for voice in movement.voices:
        period = _period(voice)
        if period is None:
            return None
        common = _common(common, Fraction(period)) if period else common
    return common / rate


def _common(one: Fraction, other: Fraction) -> Fraction:
    """The least common multiple; 0 is ignored."""
    if not one:
        return other
    return Fraction(math.lcm(one.numerator, other.numerator), math.gcd(one.denominator, other.denominator))


def _times(way: Pose, times: int) -> Pose:
    """The pose after a path is repeated `times` times, computed by repeated squaring."""
    gone = Pose()
    while times:
        if times % 2:
            gone = gone.then(way)
        way, times = way.then(way), times // 2
    return gone
