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
from improv_core.transcription.grouping import Grouped, grouped, motions_of
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
"""The most rows of a robot: of more samples, neighbors share a row."""
_WORD = 4.0
"""The cost of a measure, in natural units of information."""
_DIGIT = 2.3
"""The cost of each further digit."""
_Unknown: TypeAlias = "tuple[str, int] | tuple[int, int]"
"""A robot or the number of a group, and a coordinate of its start or an amount."""
_Column: TypeAlias = list[list[float]]
"""Values of x, y, z, and the heading, in standard deviations of the noise."""


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
        number, share = self.at(beat)
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
        return _apart(pose, sample.pose)

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
                    wanted[one] += sum(map(_dot, column, missed))
                    for other in columns:
                        if other <= one:
                            normal[one][other] += sum(map(_dot, column, columns[other]))
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

    def _poses(self, robot: str, places: Sequence[tuple[int, float]]) -> list[Pose]:
        """Return the poses of a robot after shares of its motions."""
        twists = [Twist(*self._groups.motion(each).amounts) for each in self._groups.members[robot]] or [Twist()]
        starts = list(accumulate(twists, lambda pose, twist: pose.after(twist, 1.0), initial=self._starts[robot]))
        return [starts[number].after(twists[number], share) for number, share in places]

    def _columns(self, robot: str, tracked: TrackedRobot, tempo: int) -> tuple[dict[int, _Column], _Column]:
        """Return how the poses of a robot change with each unknown, and how far they are from its track: neighboring
        samples, for which their middle one stands, together."""
        track, path = tracked.track, TranscribedPath(self._starts[robot], self._groups.items(robot))
        places = [path.at((sample.time - track[0].time) * tempo / 60) for sample in track]
        poses = self._poses(robot, places)
        missed = [_apart(pose, sample.pose) for pose, sample in zip(poses, track, strict=True)]
        size = math.ceil(len(track) / _MAX_ROWS)
        firsts = range(0, len(track) - size + 1, size)
        means = [[sum(each) / size for each in zip(*missed[first : first + size], strict=True)] for first in firsts]
        middles = [places[first + size // 2] for first in firsts]
        poses = [poses[first + size // 2] for first in firsts]
        meters, radians = (math.sqrt(size) / each for each in tracked.noise)
        weights = (meters, meters, meters, radians)
        values = self._values()
        used = {(member.group, at) for member in self._groups.members[robot] for at in range(4) if member.signs[at]}
        columns = {}
        for place, unknown in enumerate(self._unknowns):
            if unknown in used or unknown[0] == robot:
                nudged = copy(self)
                nudged._set([*values[:place], values[place] + _NUDGE, *values[place + 1 :]])
                changes = list(map(_apart, poses, nudged._poses(robot, middles)))
                columns[place] = _column(changes, [weight / _NUDGE for weight in weights])
        return columns, _column(means, weights)


def _apart(one: Pose, other: Pose) -> tuple[float, float, float, float]:
    return other.x - one.x, other.y - one.y, other.z - one.z, other.heading - one.heading


def _column(rows: Sequence[Sequence[float]], weights: Sequence[float]) -> _Column:
    """Return weighted values of each coordinate; none of one that is always 0."""
    found = zip(zip(*rows, strict=True), weights, strict=True)
    return [[value * weight for value in axis] if any(axis) else [] for axis, weight in found]


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
    return float(sum(map(mul, one, other)))
