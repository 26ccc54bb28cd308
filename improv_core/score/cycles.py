"""The beats from which on a movement repeats itself, and at which its robot is back. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterable
from fractions import Fraction
from typing import NamedTuple

from improv_core.score.algebra import Parallel, Repeat
from improv_core.score.measured import in_si
from improv_core.score.motion import Pose
from improv_core.score.movement import ENDLESS, NOTHING_AROUND, Exact, InTurn, Movement, Through
from improv_core.score.path import MAX_MEASURED_LIVE, common_multiple, displacement
from improv_core.score.score import Part
from improv_core.score.throws import ROBOTS, Dice, dice_of
from improv_core.score.walk import walk

MAX_ROUNDS = 1_000
"""Rounds after which a robot that isn't back counts as drifting."""
_SAME_PLACE = 1e-9
"""Meters and radians by which rounding may keep a path from closing."""


class Cycle(NamedTuple):
    """A stretch that repeats every `beats` beats from beat `begins` on; 0 beats if it is one velocity for good."""

    begins: Exact
    beats: Exact


def cycle(movement: Movement) -> Cycle | None:
    """Return the cycle of a movement's velocity, in its own beats. None if it never repeats."""
    return _cycle(movement, dice_of(ROBOTS) if movement.dice else None)


def closed_cycle(part: Part) -> Cycle | None:
    """Return the cycle of a robot, poses included, in beats of the performance. None if it drifts."""
    found = cycle(part.movement)
    if found is None:
        return None
    begins = part.begins + found.begins
    if found.beats == 0:
        beats = _circle(part, found.begins)
        return None if beats is None else Cycle(begins, beats)
    before, after = (
        displacement(part.movement, beats, part.profile, MAX_MEASURED_LIVE)
        for beats in (found.begins, found.begins + found.beats)
    )
    if before is None or after is None:
        return None
    gone = once = before.inverse().then(after)
    for rounds in range(1, MAX_ROUNDS + 1):
        if _is_origin(gone):
            return Cycle(begins, found.beats * rounds)
        gone = gone.then(once)
    return None


def common_cycle(cycles: Iterable[Cycle | None]) -> Cycle | None:
    """Return the cycle in which all repeat together. None if one of them never does."""
    begins: Exact = 0
    beats = Fraction(0)
    for each in cycles:
        if each is None:
            return None
        begins = max(begins, each.begins)
        beats = common_multiple(beats, Fraction(each.beats)) if each.beats else beats
    return Cycle(begins, beats)


def _cycle(movement: Movement, dice: Dice | None) -> Cycle | None:
    begins: Exact = 0
    rate = Fraction(1)
    while movement.duration == ENDLESS and movement.uniform is None:
        if isinstance(movement, Parallel):
            voices = ((place, voice) for place, voice in enumerate(movement.items) if voice.duration)
            found = common_cycle(_cycle(voice, dice and dice.inside(place)) for place, voice in voices)
            return found and Cycle(begins + found.begins / rate, found.beats / rate)
        if isinstance(movement, Through):
            rate *= movement.within(NOTHING_AROUND).rate
            movement, _, _, dice = movement.inner(0, False, dice)
        elif isinstance(movement, Repeat) and (beats := movement.body.duration) and not isinstance(beats, float):
            return None if movement.body.bounds.throws else Cycle(begins, beats / rate)  # each round throws other dice
        else:
            assert isinstance(movement, InTurn)
            for part, _, _, own in movement.visits(0, False, dice):
                if isinstance(part.duration, float):
                    movement, dice = part, own
                    break
                begins += part.duration / rate
    return Cycle(begins if isinstance(movement.duration, float) else begins + movement.duration / rate, 0)


def _circle(part: Part, begins: Exact) -> Exact | None:
    """The beats after which a robot that keeps its velocity from a beat of its own on is back; None if never."""
    if not isinstance(part.movement.duration, float):
        return 0
    velocity = next(walk(part.movement, begins)).velocity
    if not (velocity.x or velocity.y or velocity.z):
        return 0  # a disc that turns stays as it is
    turn = Fraction(90 if part.profile.quarter_turn == math.pi / 2 else 0)
    degrees = in_si(velocity.yaw, turn, turn, Fraction(1))  # whole degrees have an exact sum, radians don't
    is_exact = turn or not in_si(velocity.yaw, Fraction(1), Fraction(1), Fraction(0))
    return abs(360 / degrees) if degrees and not velocity.z and is_exact else None


def _is_origin(pose: Pose) -> bool:
    far, turned = pose.apart(Pose())
    return far < _SAME_PLACE and turned < _SAME_PLACE
