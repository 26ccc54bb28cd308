"""Takes motions for the same that differ only by noise. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from operator import mul
from typing import NamedTuple

from improv_core.transcription.amounts import Amounts
from improv_core.transcription.rhythm import TimedItem, TimedMotion, TrackedRobot

_CLEAR = 3.0
"""The standard deviations by which amounts that are the same may differ."""
_LEAST = 2e-4
"""The meters or radians by which they may always differ."""


class GroupMember(NamedTuple):
    """A motion that has the amounts of its group, with these signs: -1, 0, or 1."""

    group: int
    beats: Fraction
    signs: Sequence[int]

    def motion(self, amounts: Sequence[float]) -> TimedMotion:
        return TimedMotion(self.beats, Amounts(*map(mul, self.signs, amounts)))


def grouped(
    items: Mapping[str, Sequence[TimedItem]], robots: Mapping[str, TrackedRobot], tempo: int
) -> tuple[list[Amounts], dict[str, list[GroupMember]]]:
    """Return the amounts of groups, none of them negative, and the group of each motion: one for all that are as long
    and the same up to noise, but for signs."""
    groups: list[tuple[Fraction, list[Amounts]]] = []
    members: dict[str, list[GroupMember]] = {}
    for robot, (track, noise, *_) in robots.items():
        members[robot] = []
        rate = len(track) / (track[-1].time - track[0].time) * 60 / tempo
        for beats, amounts in motions_of(items[robot]):
            count = max(float(beats) * rate, 2.0)  # of samples; the deviation of a slope is that of their ends
            radians = _CLEAR * noise.radians * math.sqrt(12 / count)
            meters = math.hypot(_CLEAR * noise.meters * math.sqrt(12 / count), amounts.size * radians / 4)
            limits = (*[max(meters, _LEAST)] * 3, max(radians, _LEAST))
            signs = [(value > limit) - (value < -limit) for value, limit in zip(amounts, limits, strict=True)]
            size = Amounts(*map(mul, signs, amounts))
            alike = (
                at
                for at, (length, group) in enumerate(groups)
                if length == beats and _is_near(_mean(group), size, limits)
            )
            if (near := next(alike, len(groups))) == len(groups):
                groups.append((beats, []))
            groups[near][1].append(size)
            members[robot].append(GroupMember(near, beats, signs))
    return [_mean(group) for _, group in groups], members


def motions_of(items: Sequence[TimedItem]) -> list[TimedMotion]:
    """Return all motions of items, in order."""
    return [motion for item in items for motion in item.motions]


def _mean(group: Sequence[Amounts]) -> Amounts:
    return Amounts(*(math.fsum(values) / len(group) for values in zip(*group, strict=True)))


def _is_near(one: Amounts, other: Amounts, limits: Sequence[float]) -> bool:
    return all(abs(a - b) <= limit and (a == 0) == (b == 0) for a, b, limit in zip(one, other, limits, strict=True))
