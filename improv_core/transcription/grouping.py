"""Takes motions for the same that differ only by noise. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

from improv_core.transcription.rhythm import Gentle, Item, TimedMotion
from improv_core.transcription.stretches import Amounts
from improv_core.transcription.track import Noise

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


def grouped(items: Mapping[str, Sequence[Item]], noises: Sequence[Noise]) -> Grouped:
    """Return items whose motions share their amounts if they are as long and nearly the same, but for signs."""
    meters = max([2e-4, *(2.0 * noise.meters for noise in noises)])
    radians = max([2e-4, *(1.5 * noise.radians for noise in noises)])
    groups: list[list[Amounts]] = []
    found: dict[Fraction, list[int]] = {}
    members: dict[str, list[GroupMember]] = {}
    for robot, each in items.items():
        members[robot] = []
        for motion in motions_of(each):
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
    return Grouped(items, members, [_mean(group) for group in groups])


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
