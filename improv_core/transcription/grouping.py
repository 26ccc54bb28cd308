"""Takes motions for the same that differ only by noise. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

from improv_core.transcription.amounts import Amounts
from improv_core.transcription.rhythm import Gentle, Item, TimedMotion, TrackedRobot

_CLEAR = 3.0
"""The standard deviations by which amounts that are the same may differ."""
_LEAST = 2e-4
"""The meters or radians by which they may always differ."""
Signs = tuple[int, int, int, int]


class GroupMember(NamedTuple):
    """A motion that has the amounts of its group, with these signs."""

    beats: Fraction
    group: int
    signs: Signs


@dataclass(frozen=True, slots=True)
class Grouped:
    """Items whose motions have the amounts of groups. A group's amounts are not negative."""

    shapes: Mapping[str, Sequence[Item]]
    members: Mapping[str, Sequence[GroupMember]]
    amounts: Sequence[Amounts]
    beats: Mapping[int, Fraction]

    @property
    def unknowns(self) -> list[tuple[int, int]]:
        """The numbers of groups, and the amounts of them that aren't 0: turns first, since radii depend on them."""
        return [(group, at) for at in (3, 0, 1, 2) for group, each in enumerate(self.amounts) if each[at]]

    def items(self, robot: str) -> list[Item]:
        """Return a robot's items with the amounts of their groups."""
        motions = iter([self.motion(each) for each in self.members[robot]])
        return [
            replace(item, motions=tuple(next(motions) for _ in item.motions))
            if isinstance(item, Gentle)
            else next(motions)
            for item in self.shapes[robot]
        ]

    def motion(self, member: GroupMember) -> TimedMotion:
        amounts = Amounts(*(sign * value for sign, value in zip(member.signs, self.amounts[member.group], strict=True)))
        return TimedMotion(member.beats, amounts)


def grouped(items: Mapping[str, Sequence[Item]], robots: Mapping[str, TrackedRobot], tempo: int) -> Grouped:
    """Return items whose motions share their amounts if they are as long and the same up to noise, but for signs."""
    groups: list[list[Amounts]] = []
    found: dict[Fraction, list[int]] = {}
    members: dict[str, list[GroupMember]] = {}
    for robot, each in items.items():
        members[robot] = []
        track, noise = robots[robot].track, robots[robot].noise
        rate = len(track) / (track[-1].time - track[0].time) * 60 / tempo
        for motion in motions_of(each):
            count = max(float(motion.beats) * rate, 2.0)  # of samples; the deviation of a slope is that of their ends
            radians = _CLEAR * noise.radians * math.sqrt(12 / count)
            meters = math.hypot(_CLEAR * noise.meters * math.sqrt(12 / count), motion.amounts.size * radians / 4)
            meters, radians = max(meters, _LEAST), max(radians, _LEAST)
            signs, size = _signs(motion.amounts, meters, radians)
            near = next(
                (at for at in found.get(motion.beats, ()) if _is_near(_mean(groups[at]), size, meters, radians)), None
            )
            if near is None:
                near = len(groups)
                groups.append([])
                found.setdefault(motion.beats, []).append(near)
            groups[near].append(size)
            members[robot].append(GroupMember(motion.beats, near, signs))
    beats = {at: beats for beats, each in found.items() for at in each}
    return Grouped(items, members, [_mean(group) for group in groups], beats)


def motions_of(items: Sequence[Item]) -> list[TimedMotion]:
    """Return all motions of items, in order."""
    return [motion for item in items for motion in (item.motions if isinstance(item, Gentle) else (item,))]


def _signs(amounts: Amounts, meters: float, radians: float) -> tuple[Signs, Amounts]:
    limits = (meters, meters, meters, radians)
    signs = tuple(
        0 if abs(value) <= limit else int(math.copysign(1, value)) for value, limit in zip(amounts, limits, strict=True)
    )
    size = Amounts(*(abs(value) if sign else 0.0 for sign, value in zip(signs, amounts, strict=True)))
    return signs, size  # type: ignore[return-value]


def _mean(group: Sequence[Amounts]) -> Amounts:
    return Amounts(*(math.fsum(values) / len(group) for values in zip(*group, strict=True)))


def _is_near(one: Amounts, other: Amounts, meters: float, radians: float) -> bool:
    limits = (meters, meters, meters, radians)
    return all(abs(a - b) <= limit and (a == 0) == (b == 0) for a, b, limit in zip(one, other, limits, strict=True))
