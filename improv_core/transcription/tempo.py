"""Finds the tempo at which most changes fall on beats, or on simple parts of beats. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

USUAL = 60
"""The tempo of a program that says none."""
SLOWEST, FASTEST = 30, 240
PARTS = (1, 2, 3, 4, 6, 8)
"""A beat is divided by these, the simplest first."""
_FINEST_PART = 1000
"""The finest part of a beat that is ever written."""
_MISS = 3.0
"""Bits that a change costs that falls on no part of a beat, besides those of its time."""


def tempi(changes: Sequence[float], allowed: float, most: int = 3) -> list[int]:
    """Return the likeliest tempi for changes at these seconds from beat 0, the best one first.

    Each change costs the bits that encode its place: fewer on a coarse grid, more on a fine one, most outside of all
    grids (minimum description length). `allowed` is how many seconds a change may be off.
    """
    if not changes:
        return [USUAL]
    costs = {
        tempo: rareness(tempo) + math.fsum(_bits(time, tempo, allowed) for time in changes)
        for tempo in range(SLOWEST, FASTEST + 1)
    }
    ranked = sorted(costs, key=lambda tempo: (round(costs[tempo], 6), tempo != USUAL, tempo))
    return ranked[:most]


def multiples(tempo: int, most: int) -> list[int]:
    """Return the tempi whose ratio to this one is a fraction of numbers up to `most`."""
    times = [Fraction(tempo * times, parts) for times in range(1, most + 1) for parts in range(1, most + 1)]
    return [int(each) for each in times if each.denominator == 1 and SLOWEST <= each <= FASTEST]


def rareness(tempo: int) -> float:
    """Return the bits that a tempo costs: people choose round numbers."""
    return 0.0 if tempo == USUAL else 4.0 if not tempo % 10 else 5.0 if not tempo % 5 else 7.0


def _bits(time: float, tempo: int, allowed: float) -> float:
    beats, second = time * tempo / 60, tempo / 60
    for parts in PARTS:
        off = abs(beats * parts - round(beats * parts)) / parts / second
        if off <= allowed:
            return math.log2(second * parts) + (off / allowed) ** 2
    return math.log2(1 / allowed) + _MISS


def on_grid(seconds: float, tempo: float, allowed: float) -> Fraction:
    """Return the simplest number of beats within `allowed` seconds of this time."""
    beats, off = seconds * tempo / 60, allowed * tempo / 60
    for parts in (*PARTS, *range(5, _FINEST_PART + 1)):
        count = round(beats * parts)
        if abs(count - beats * parts) <= off * parts:
            break
    return Fraction(count, parts)
