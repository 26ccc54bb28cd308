"""Functions that are linear between knots. Standard library only."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable
from itertools import accumulate


def polyline(steps: Iterable[tuple[float, float]]) -> Callable[[float], float]:
    """Return the function that is 0 at 0, and then has a slope over a length, as each step says.

    It goes on straight before 0 and after the last step.
    """
    steps = list(steps)
    starts = list(accumulate((length for length, _ in steps), initial=0.0))
    values = list(accumulate((length * slope for length, slope in steps), initial=0.0))

    def value(at: float) -> float:
        place = min(max(bisect_right(starts, at) - 1, 0), len(steps) - 1)
        return values[place] + (at - starts[place]) * steps[place][1]

    return value
