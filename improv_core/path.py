"""The way a movement goes: how far it travels and how much it turns, in steps and quarter turns."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import islice

from improv_core import movement as algebra
from improv_core.movement import ENDLESS, Movement, walk

MOST_MOMENTS = 10_000
"""Voices side by side are walked to measure them; beyond this many moments their way is not known."""


@dataclass(frozen=True, slots=True)
class Extent:
    """The length of the way in steps, however it bends, and the turning in quarter turns, left positive."""

    steps: float
    turns: float


def extent(movement: Movement) -> Extent | None:
    """The extent of a movement; None where it is endless or too long to be walked.

    Repeats are multiplied, not walked; parts are measured before what is made of them, without recursion.
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
        known[id(part)] = _extent(part, [known[id(child)] for child in inner])
    return known[id(movement)]


def _extent(part: Movement, inner: list[Extent | None]) -> Extent | None:
    if isinstance(part, (algebra.Hold, algebra.Parallel)):
        return _walked(part)
    known = [each for each in inner if each]
    if len(known) < len(inner):
        return None
    steps, turns = math.fsum(each.steps for each in known), math.fsum(each.turns for each in known)
    if isinstance(part, algebra.Repeat):
        return Extent(steps * (part.times or 0), turns * (part.times or 0))
    if isinstance(part, algebra.Gain):
        # Every gain of the language is one factor with signs, so that all lengths grow alike.
        return Extent(steps * float(abs(part.gain.x)), turns * float(part.gain.yaw))
    return Extent(steps, turns)


def _walked(part: Movement) -> Extent | None:
    steps, turns = [], []
    for count, moment in enumerate(islice(walk(part, merge=True), MOST_MOMENTS + 1)):
        if count == MOST_MOMENTS:
            return None
        x, y, z, yaw = (float(value * moment.duration) for value in moment.velocity)
        steps.append(math.hypot(x, y, z))
        turns.append(yaw)
    return Extent(math.fsum(steps), math.fsum(turns))
