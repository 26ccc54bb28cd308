"""Limits of movements: their length, their speed, and the size of their fractions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from improv_core.score.bounds import is_too_fast
from improv_core.score.movement import ENDLESS, LARGEST, MOST_BITS, MOST_THROWS, Movement, bits

FEW = 50
"""The most fractions that are added without checking their common denominator."""
_FEW_BITS = 150
"""A movement whose numbers have so few bits is neither too long nor too fast: its factors are below 2^300 together."""
TOO_LONG = "these numbers make a fraction too long to compute exactly: use simpler ones"


def too_much(made: Movement) -> str | None:
    """Return the message about numbers too long to stay exact or too large for a float; None if there are none.

    All code that converts a movement's numbers to floats relies on this check.
    """
    duration, bounds = made.duration, made.bounds
    length = bounds.bits if isinstance(duration, float) else bounds.bits + bits(duration)
    if length <= _FEW_BITS and not bounds.throws:
        return None
    if LARGEST < duration < ENDLESS or is_too_fast(bounds.peak) or is_too_fast(bounds.body.peak):
        return "these numbers make the movement too long or too fast to play: use smaller ones"
    if bounds.throws > MOST_THROWS:
        return "these numbers make too many throws of the dice: use smaller ones"
    return TOO_LONG if length > MOST_BITS else None


def share_a_denominator(items: Sequence[Movement]) -> bool:
    """Return whether durations can be added exactly: a sum of thousands of unrelated fractions keeps getting longer."""
    common = 1
    for item in items:
        if isinstance(item.duration, Fraction):
            common = math.lcm(common, item.duration.denominator)
            if common.bit_length() > MOST_BITS:
                return False
    return True
