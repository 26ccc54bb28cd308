"""The least distances that robots ideally have to each other, and their beats. Standard library only."""

from __future__ import annotations

import math
from itertools import combinations
from typing import NamedTuple

from improv_core.score.approach import jump, relative
from improv_core.score.budget import Budget, TooLongError
from improv_core.score.score import Score
from improv_core.score.strokes import pictured
from improv_core.score.trajectories import BLOCK, Beat, Segment, Trajectory

EXACT = 1e-4
"""Meters by which a distance may be off."""
MAX_WORK = 1_000_000
"""The most moments that are examined, which takes a second or two."""


class Nearest(NamedTuple):
    """A distance between two centers, in meters, and the beat at which they first reach it."""

    distance: float
    beat: float


def nearest_pairs(score: Score, end: float, below: float) -> dict[tuple[str, str], Nearest]:
    """Return the least distance of each pair that comes nearer than some distance before a beat.

    It is as if no sense held. Pairs that would take too long are left out.
    """
    trajectories = {name: Trajectory(part) for name, part in pictured(score).parts.items()}
    found: dict[tuple[str, str], Nearest] = {}
    work = Budget(MAX_WORK)
    try:
        for number in range(math.ceil(end / BLOCK)):
            for one, other in combinations(trajectories, 2):
                blocks = trajectories[one].block(number), trajectories[other].block(number)
                if not (blocks[0] and blocks[1]):
                    return found
                work.spend()
                best = found.get((one, other), Nearest(below, math.inf))
                if not blocks[0].box.is_within(blocks[1].box, best.distance):
                    continue
                for begin, (mine, others) in enumerate(
                    zip(blocks[0].beats, blocks[1].beats, strict=True), number * BLOCK
                ):
                    best = _within(mine, others, begin, min(begin + 1.0, end), best, work)
                if best.beat < math.inf:
                    found[one, other] = best
    except TooLongError:
        pass
    return found


def _within(one: Beat, other: Beat, begin: float, end: float, best: Nearest, work: Budget) -> Nearest:
    """Return the least distance so far, including that within some segments of a beat."""
    if one.box.is_within(other.box, best.distance):
        for mine in one.segments:
            for others in other.segments:
                since, until = max(mine.start, others.start, begin), min(mine.end, others.end, end)
                if since < until:
                    best = _along(mine, others, since, until, best, work)
    return best


def _along(one: Segment, other: Segment, now: float, end: float, best: Nearest, work: Budget) -> Nearest:
    speeds = [math.hypot(each.along_x, each.along_y, each.along_z) for each in (one, other)]
    bend = speeds[0] * abs(one.turn) + speeds[1] * abs(other.turn)
    while True:
        work.spend()
        x, y, along_x, along_y = relative(one, other, now)
        z = other.z + other.along_z * (now - other.start) - one.z - one.along_z * (now - one.start)
        rise = other.along_z - one.along_z
        far = math.hypot(x, y, z)
        if far < best.distance:
            best = Nearest(far, now)
        if now >= end:
            return best
        closing = -(x * along_x + y * along_y + z * rise) / (far or 1.0)
        now = min(now + jump(max(far - best.distance, 0.0) + EXACT, closing, sum(speeds), bend), end)
