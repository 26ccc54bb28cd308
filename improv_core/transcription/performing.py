"""Performs what was found, and compares it with tracks. Standard library only."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Mapping, Sequence
from itertools import accumulate

from improv_core.score.motion import Pose, Twist
from improv_core.transcription.grouping import motions_of
from improv_core.transcription.polyline import polyline
from improv_core.transcription.rhythm import TimedItem, TimedMotion
from improv_core.transcription.track import Sample, Track

SHIFTS = (0.0, -0.5, 0.5, -1.0, 1.0)
"""Shares of the seconds by which a robot may be early or late."""


class ItemTiming:
    """The times at which a robot performs its motions."""

    def __init__(self, items: Sequence[TimedItem]) -> None:
        self._lengths = [float(each.beats) for each in motions_of(items)] or [1.0]
        self._ends = list(accumulate(self._lengths))
        self._played = polyline([step for item in items for step in item.steps] or [(1.0, 1.0)])

    def at(self, beat: float) -> tuple[int, float]:
        """Return the number of the motion that the robot performs, and the share of it that is over."""
        played = self._played(beat)
        number = min(bisect_right(self._ends, played), len(self._ends) - 1)
        return number, min(max(1 - (self._ends[number] - played) / self._lengths[number], 0.0), 1.0)


class PerformedPath:
    """Poses of a robot that performs motions one after another."""

    def __init__(self, start: Pose, motions: Sequence[TimedMotion]) -> None:
        self._twists = [Twist(*each.amounts) for each in motions] or [Twist()]
        self._starts = list(accumulate(self._twists, lambda pose, twist: pose.after(twist, 1.0), initial=start))

    def pose(self, number: int, share: float) -> Pose:
        """Return the pose after a share of a motion."""
        return self._starts[number].after(self._twists[number], share)


def deviations_of(
    track: Track, start: Pose, items: Sequence[TimedItem], tempo: int, limits: Mapping[int, tuple[float, float, float]]
) -> list[tuple[float, float]]:
    """Return how far means of neighboring poses are from a performance at most, in meters and radians.

    `limits` has numbers of neighbors, and what is allowed for their means in meters, radians, and seconds: where they
    are farther away, the performance may be early or late.
    """
    timing, path = ItemTiming(items), PerformedPath(start, motions_of(items))
    origin = track[0].time

    def missed(sample: Sample, late: float) -> tuple[float, float, float, float]:
        pose = path.pose(*timing.at((sample.time - origin + late) * tempo / 60))
        return differences(pose, sample.pose)

    def apart(misses: Sequence[tuple[float, float, float, float]]) -> tuple[float, float]:
        x, y, z, yaw = (sum(each) / len(misses) for each in zip(*misses, strict=True))
        return math.hypot(x, y, z), abs(yaw)

    misses = [missed(sample, 0.0) for sample in track]
    found = []
    for window, (meters, radians, seconds) in limits.items():
        worst = (0.0, 0.0)
        for first in range(len(track) - window + 1):
            far, turned = apart(misses[first : first + window])
            if far > meters or turned > radians:
                near = track[first : first + window]
                others = [apart([missed(each, shift * seconds) for each in near]) for shift in SHIFTS]
                far, turned = min(others, key=lambda each: max(each[0] / meters, each[1] / radians))
            worst = max(worst[0], far), max(worst[1], turned)
        found.append(worst)
    return found


def differences(one: Pose, other: Pose) -> tuple[float, float, float, float]:
    return other.x - one.x, other.y - one.y, other.z - one.z, other.heading - one.heading
