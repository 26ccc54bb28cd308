"""Performs what was found, compares it with tracks, and makes it nearer to them, in rounder numbers. Standard library
only."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import replace
from fractions import Fraction
from itertools import accumulate
from operator import mul
from typing import TypeAlias

from improv_core.score.motion import Pose, Twist
from improv_core.score.profiles import Profile
from improv_core.transcription.amounts import Amounts
from improv_core.transcription.grouping import Grouped, GroupMember, grouped, motions_of
from improv_core.transcription.rhythm import Gentle, Item, TimedMotion, TrackedRobot
from improv_core.transcription.track import Sample, Track
from improv_core.transcription.wording import ANGLES, LENGTHS

SHIFTS = (0.0, -0.5, 0.5, -1.0, 1.0)
"""Shares of the seconds by which a robot may be early or late."""
_STEPS = 2
"""The number of times that amounts are improved: each step nearly ends the error that is left."""
_MAX_UNKNOWNS = 160
_NUDGE = 1e-5
_RIDGE = 1e-9
"""The weight of an unknown besides that of its samples, so that one on which they don't depend stays as it is."""
_MAX_ROWS = 300
"""The most rows of a robot: neighboring samples are added up to one row."""
_WORD = 4.0
"""The cost of a measure, in natural units of information."""
_DIGIT = 2.3
"""The cost of each further digit."""
_Unknown: TypeAlias = "tuple[str, int] | tuple[int, int]"
"""A robot or the number of a group, and a coordinate of its start or an amount."""
_UNITS = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0))


class TranscribedPath:
    """Poses of a robot that performs motions one after another, some at a rate that changes."""

    def __init__(self, start: Pose, items: Sequence[Item]) -> None:
        items = items or [TimedMotion(Fraction(1), Amounts(0.0, 0.0, 0.0, 0.0))]
        self.motions = motions_of(items)
        self.starts = list(accumulate((each.amounts.pose() for each in self.motions), Pose.then, initial=start))
        self._items = [
            (float(each.beats), each.curve.progress(each.beats) if isinstance(each, Gentle) else float)
            for each in items
        ]
        self._timed = [(float(each.beats), Twist(*each.amounts)) for each in self.motions]
        self._firsts = list(accumulate((len(motions_of([each])) for each in items), initial=0))
        self._ends = list(accumulate(beats for beats, _ in self._items))

    def at(self, beat: float) -> tuple[int, float]:
        """Return the number of the motion that a robot performs, and the share of it that is over."""
        place = bisect_right(self._ends, beat)
        if place == len(self._items):
            return len(self.motions) - 1, 1.0
        beats, played = self._items[place]
        left = played(max(beat - (self._ends[place] - beats), 0.0))
        for number in range(self._firsts[place], self._firsts[place + 1]):
            length = self._timed[number][0]
            if left < length:
                return number, left / length
            left -= length
        return self._firsts[place + 1] - 1, 1.0

    def pose(self, beat: float) -> Pose:
        return self.pose_in(*self.at(beat))

    def pose_in(self, number: int, share: float) -> Pose:
        """Return the pose after a share of a motion."""
        return self.starts[number].after(self._timed[number][1], share)


def deviations_of(
    track: Track, start: Pose, items: Sequence[Item], tempo: int, limits: Mapping[int, tuple[float, float, float]]
) -> list[tuple[float, float]]:
    """Return how far means of neighboring poses are from a performance at most, in meters and radians.

    `limits` has numbers of neighbors, and what is allowed for their means in meters, radians, and seconds: where they
    are farther away, the performance may be early or late.
    """
    performed = TranscribedPath(start, items)
    origin = track[0].time

    def missed(sample: Sample, late: float) -> tuple[float, float, float, float]:
        pose = performed.pose((sample.time - origin + late) * tempo / 60)
        return sample.x - pose.x, sample.y - pose.y, sample.z - pose.z, sample.heading - pose.heading

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


def fits_of(
    items: Mapping[str, Sequence[Item]], starts: Mapping[str, Pose], robots: Mapping[str, TrackedRobot], tempo: int
) -> list[FittedGroups]:
    """Return the fit of all robots together, or those of each half of them if they have too many unknowns.

    A robot that has too many alone keeps its items.
    """
    groups = grouped({robot: items[robot] for robot in robots}, robots, tempo)
    if len(groups.unknowns) + 4 * len(robots) <= _MAX_UNKNOWNS:
        return [FittedGroups(groups, {robot: starts[robot] for robot in robots}, robots, tempo)]
    names = [*robots]
    halves = (names[: len(names) // 2], names[len(names) // 2 :]) if len(names) > 1 else ()
    return [fit for half in halves for fit in fits_of(items, starts, {each: robots[each] for each in half}, tempo)]


class FittedGroups:
    """The amounts of groups, and the poses at which robots start, that are nearest to tracks.

    They are found by least squares (Gauss-Newton), in standard deviations of the noise.
    """

    def __init__(
        self, groups: Grouped, starts: Mapping[str, Pose], robots: Mapping[str, TrackedRobot], tempo: int
    ) -> None:
        self._groups, self._starts = groups, starts
        self._unknowns: list[_Unknown] = [*groups.unknowns, *((robot, at) for robot in robots for at in range(4))]
        self._factors: list[list[float]] = []
        self._variances: list[float] = []
        for _ in range(_STEPS):
            count = len(self._unknowns)
            normal = [[0.0] * count for _ in range(count)]
            wanted = [0.0] * count
            for robot, tracked in robots.items():
                columns, missed = self._columns(robot, tracked, tempo)
                for one, column in columns.items():
                    wanted[one] += _dot(column, missed)
                    for other in columns:
                        if other <= one:
                            normal[one][other] += _dot(column, columns[other])
            self._factors, self._variances = _factored(normal)
            change = _solved(self._factors, self._variances, wanted)
            self._set([old + by for old, by in zip(self._values(), change, strict=True)])

    def rounded(self, strictness: float, profile: Profile) -> tuple[Mapping[str, Sequence[Item]], Mapping[str, Pose]]:
        """Return items and starts in numbers as people write them: each costs what it takes to read it, and how badly
        it then fits, times `strictness`. Those that follow make up for what is rounded.

        This is the sequential rounding of integer least squares (Teunissen, 1998).
        """
        off: list[float] = []
        kept: list[float] = []
        for place, (value, variance) in enumerate(zip(self._values(), self._variances, strict=True)):
            likely = value + _dot(self._factors[place], off)
            who, at = self._unknowns[place]
            yaw = 0.0
            if not isinstance(who, str) and at == 0 and (who, 3) in self._unknowns:
                yaw = kept[self._unknowns.index((who, 3))]
            beats = Fraction(0) if isinstance(who, str) else self._groups.beats[who]
            options = [*_options(likely, beats, at, profile, yaw)]
            made, _ = min(options, key=lambda each: each[1] + strictness * (each[0] - likely) ** 2 / variance / 2)
            off.append(value - made)
            kept.append(made)
        fitted = copy(self)
        fitted._set(kept)
        return {robot: fitted._groups.items(robot) for robot in self._starts}, fitted._starts

    def _values(self) -> list[float]:
        poses = {robot: (pose.x, pose.y, pose.z, pose.heading) for robot, pose in self._starts.items()}
        return [poses[who][at] if isinstance(who, str) else self._groups.amounts[who][at] for who, at in self._unknowns]

    def _set(self, values: Sequence[float]) -> None:
        poses = {robot: [pose.x, pose.y, pose.z, pose.heading] for robot, pose in self._starts.items()}
        amounts = [list(each) for each in self._groups.amounts]
        for (who, at), value in zip(self._unknowns, values, strict=True):
            (poses[who] if isinstance(who, str) else amounts[who])[at] = value
        self._groups = replace(self._groups, amounts=[Amounts(*each) for each in amounts])
        self._starts = {robot: Pose(*each) for robot, each in poses.items()}

    def _columns(self, robot: str, tracked: TrackedRobot, tempo: int) -> tuple[dict[int, list[float]], list[float]]:
        """Return how the poses of a robot change with each unknown, and how far they are from its track."""
        track, noise = tracked.track, tracked.noise
        weights = (1 / noise.meters, 1 / noise.meters, 1 / noise.meters, 1 / noise.radians)
        path = TranscribedPath(self._starts[robot], self._groups.items(robot))
        members = self._groups.members[robot]
        places = [path.at((sample.time - track[0].time) * tempo / 60) for sample in track]
        poses = [path.pose_in(*place) for place in places]
        missed = [(s.x - p.x, s.y - p.y, s.z - p.z, s.heading - p.heading) for s, p in zip(track, poses, strict=True)]
        columns = {}
        start = self._starts[robot]
        for place, (who, at) in enumerate(self._unknowns):
            if who == robot:
                spun = [(start.y - p.y, p.x - start.x, 0.0, 1.0) if at == 3 else _UNITS[at] for p in poses]
                columns[place] = _row(spun, weights)
            elif not isinstance(who, str) and any(each.group == who and each.signs[at] for each in members):
                columns[place] = _row(self._moved(path, members, who, at, places, poses), weights)
        return columns, _row(missed, weights)

    def _moved(
        self,
        path: TranscribedPath,
        members: Sequence[GroupMember],
        group: int,
        at: int,
        places: Sequence[tuple[int, float]],
        poses: Sequence[Pose],
    ) -> list[tuple[float, float, float, float]]:
        """Return how poses change with an amount of a group: within its motions, and behind them as one rigid body."""
        far, lift, turn = 0j, 0.0, 0.0
        carried: list[tuple[complex, float, float, Amounts | None]] = []
        for motion, member, start, end in zip(path.motions, members, path.starts, path.starts[1:], strict=False):
            nudged = None
            if member.group == group and member.signs[at]:
                nudged = motion.amounts._replace(
                    **{Amounts._fields[at]: motion.amounts[at] + _NUDGE * member.signs[at]}
                )
            carried.append((far, lift, turn, nudged))
            if nudged:
                dx, dy, dz, spin = _change(end, start.then(nudged.pose()))
                far += complex(dx, dy) - 1j * spin * complex(end.x, end.y)
                lift, turn = lift + dz, turn + spin
        found = []
        for (number, share), pose in zip(places, poses, strict=True):
            far, lift, turn, nudged = carried[number]
            moved = far + 1j * turn * complex(pose.x, pose.y)
            if nudged:
                dx, dy, dz, spin = _change(pose, path.starts[number].then(nudged.pose(share)))
                found.append((moved.real + dx, moved.imag + dy, lift + dz, turn + spin))
            else:
                found.append((moved.real, moved.imag, lift, turn))
        return found


def _options(value: float, beats: Fraction, at: int, profile: Profile, yaw: float) -> Iterator[tuple[float, float]]:
    """Yield numbers near a value, and what each costs to read, in natural units. `beats` is the length of the motion;
    0 for a start. Forward, a robot may go along a circle by the angle `yaw`."""
    yield 0.0, -_WORD if beats else 0.0
    levels: Sequence[Fraction] = ANGLES if at == 3 else LENGTHS
    scale = math.pi / 180 if at == 3 else 1.0
    if beats:
        unit = profile.quarter_turn if at == 3 else profile.step
        copies = [Fraction(1), beats] if beats.denominator == 1 else [Fraction(1)]
        yield from ((unit * float(each), 0.0) for each in copies)
        if at == 3:
            yield from ((unit * float(each) / 2, 0.0) for each in copies)
    for digits, level in enumerate(levels):
        size = float(level) * scale
        yield round(value / size) * size, _WORD + _DIGIT * digits
        if yaw:
            yield round(value / yaw / size) * size * yaw, _WORD + _DIGIT * digits


def _change(one: Pose, other: Pose) -> tuple[float, float, float, float]:
    return (
        (other.x - one.x) / _NUDGE,
        (other.y - one.y) / _NUDGE,
        (other.z - one.z) / _NUDGE,
        (other.heading - one.heading) / _NUDGE,
    )


def _row(values: Sequence[tuple[float, float, float, float]], weights: Sequence[float]) -> list[float]:
    """Return weighted values one after another; neighbors are added up."""
    size = max(1, math.ceil(len(values) / _MAX_ROWS))
    found: list[float] = []
    for axis, weight in zip(zip(*values, strict=True), weights, strict=True):
        scale = weight / math.sqrt(size)
        if size == 1:
            found += [each * scale for each in axis]
        else:
            found += [sum(axis[first : first + size]) * scale for first in range(0, len(axis), size)]
    return found


def _factored(normal: Sequence[Sequence[float]]) -> tuple[list[list[float]], list[float]]:
    """Return M, whose diagonal of ones is left out, and D, of which Mᵀ D⁻¹ M is a symmetric matrix whose lower half is
    given, with a ridge: no pivot is lost to rounding then (Levenberg, 1944)."""
    left = [[*row[:place], row[place] * (1 + _RIDGE) + _RIDGE] for place, row in enumerate(normal)]
    factors: list[list[float]] = []
    variances: list[float] = []
    while left:
        row = left.pop()
        pivot = row.pop()
        scaled = [each / pivot for each in row]
        for other, factor in enumerate(row):
            if factor:
                left[other] = [old - factor * each for old, each in zip(left[other], scaled, strict=False)]
        factors.append(scaled)
        variances.append(1 / pivot)
    return factors[::-1], variances[::-1]


def _solved(factors: Sequence[Sequence[float]], variances: Sequence[float], wanted: Sequence[float]) -> list[float]:
    """Return the vector that a factored matrix makes `wanted`."""
    left = list(wanted)
    for place in reversed(range(len(left))):
        left[:place] = [old - left[place] * each for old, each in zip(left, factors[place], strict=False)]
    found: list[float] = []
    for place, row in enumerate(factors):
        found.append(left[place] * variances[place] - _dot(row, found))
    return found


def _dot(one: Sequence[float], other: Sequence[float]) -> float:
    return math.fsum(map(mul, one, other))
