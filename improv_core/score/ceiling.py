"""The highest tempo at which robots can play a score. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterator

from improv_core.score.ramps import FASTEST_EASE
from improv_core.score.score import Part, Score, in_axes


def ceiling(score: Score) -> tuple[str, float]:
    """Return the first robot that is too slow if the tempo rises, and that tempo in beats per minute.

    This is a bound: a robot may manage more if its voices don't all ask for their most at once.
    """
    each = ((part.robot, _most(part)) for part in score.parts.values())
    return min(each, key=lambda known: known[1], default=("", math.inf))


def _most(part: Part) -> float:
    """Return the tempo up to which a robot stays within its limits."""
    return min((limit * 60 / asked for limit, asked in _asked(part) if asked), default=math.inf)


def _asked(part: Part) -> Iterator[tuple[float, float]]:
    """Yield each limit of a robot, and the speed that a beat per second needs, in m/s and rad/s."""
    profile, peak = part.profile, part.movement.bounds.peak
    faster = float(FASTEST_EASE) if profile.smooth else 1.0
    x, y, z, yaw = in_axes(peak[:4], profile)
    if profile.max_linear is not None:
        yield profile.max_linear, math.hypot(x, y, z) * profile.linear_scale * faster
    if profile.max_angular is not None:
        yield profile.max_angular, yaw * profile.angular_scale * faster
