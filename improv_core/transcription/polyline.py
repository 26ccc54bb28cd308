"""Functions that are linear between knots. Standard library only."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Sequence


def polyline(starts: Sequence[float], values: Sequence[float], slopes: Sequence[float]) -> Callable[[float], float]:
    """Return the function that has each of these values at its start, and this slope from there to the next start.

    It goes on straight before the first start and after the last one.
    """
    last = len(slopes) - 1

    def value(at: float) -> float:
        place = min(max(bisect_right(starts, at) - 1, 0), last)
        return values[place] + (at - starts[place]) * slopes[place]

    return value
