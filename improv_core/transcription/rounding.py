"""Makes what was found nearer to tracks, in rounder numbers. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import chain, islice
from operator import mul
from typing import TypeAlias

from improv_core.score.motion import Pose
from improv_core.score.profiles import Profile
from improv_core.transcription.amounts import Amounts
from improv_core.transcription.grouping import GroupMember, grouped
from improv_core.transcription.performing import ItemTiming, PerformedPath, differences
from improv_core.transcription.rhythm import TimedItem, TrackedRobot
from improv_core.transcription.wording import ANGLES, LENGTHS

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
_Column: TypeAlias = list[list[float]]
"""Values of x, y, z, and the heading, in standard deviations of the noise."""


def fits_of(
    items: Mapping[str, Sequence[TimedItem]], starts: Mapping[str, Pose], robots: Mapping[str, TrackedRobot], tempo: int
) -> list[FittedGroups]:
    """Return the fit of all robots together, or those of each half of them if they have too many unknowns.

    A robot that has too many alone keeps its items.
    """
    amounts, members = grouped(items, robots, tempo)
    if sum(map(bool, chain(*amounts))) + 4 * len(robots) <= _MAX_UNKNOWNS:
        return [FittedGroups(items, starts, robots, tempo, amounts, members)]
    names = [*robots]
    halves = (names[: len(names) // 2], names[len(names) // 2 :]) if len(names) > 1 else ()
    return [fit for half in halves for fit in fits_of(items, starts, {each: robots[each] for each in half}, tempo)]


class FittedGroups:
    """The amounts of groups, and the poses at which robots start, that are nearest to tracks.

    They are found by least squares (Gauss-Newton), in standard deviations of the noise.
    """

    def __init__(
        self,
        items: Mapping[str, Sequence[TimedItem]],
        starts: Mapping[str, Pose],
        robots: Mapping[str, TrackedRobot],
        tempo: int,
        amounts: Sequence[Amounts],
        members: Mapping[str, Sequence[GroupMember]],
    ) -> None:
        self._items, self._members = items, members
        begun = [(pose.x, pose.y, pose.z, pose.heading) for pose in map(starts.__getitem__, robots)]
        self._rows: list[Sequence[float]] = [*amounts, *begun]
        self._starts = {robot: row for row, robot in enumerate(robots, len(amounts))}
        # Turns come first, since radii depend on them.
        self._unknowns = [(row, at) for at in (3, 0, 1, 2) for row, each in enumerate(amounts) if each[at]]
        self._unknowns += [(row, at) for row in self._starts.values() for at in range(4)]
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
            self._rows = self._with([old + by for old, by in zip(self._values(), change, strict=True)])

    def rounded(
        self, strictness: float, profile: Profile
    ) -> tuple[Mapping[str, Sequence[TimedItem]], Mapping[str, Pose]]:
        """Return items and starts in numbers as people write them: each costs what it takes to read it, and how badly
        it then fits, times `strictness`. Those that follow make up for what is rounded.

        This is the sequential rounding of integer least squares (Teunissen, 1998).
        """
        lengths = {each.group: each.beats for members in self._members.values() for each in members}
        off: list[float] = []
        kept: dict[tuple[int, int], float] = {}
        for place, (unknown, value) in enumerate(zip(self._unknowns, self._values(), strict=True)):
            likely = value + _dot(self._factors[place], off)
            row, at = unknown
            yaw = kept.get((row, 3), 0.0) if row in lengths and at == 0 else 0.0
            options = _options(likely, lengths.get(row, Fraction(0)), at, profile, yaw)
            weight = strictness / self._variances[place] / 2
            kept[unknown], _ = min(options, key=lambda each: each[1] + weight * (each[0] - likely) ** 2)
            off.append(value - kept[unknown])
        rows = self._with(list(kept.values()))
        starts = {robot: Pose(*rows[row]) for robot, row in self._starts.items()}
        return {robot: self._items_with(robot, rows) for robot in starts}, starts

    def _values(self) -> list[float]:
        return [self._rows[row][at] for row, at in self._unknowns]

    def _with(self, values: Sequence[float]) -> list[Sequence[float]]:
        """Return the rows with these values of the unknowns."""
        rows = [list(each) for each in self._rows]
        for (row, at), value in zip(self._unknowns, values, strict=True):
            rows[row][at] = value
        return [*rows]

    def _items_with(self, robot: str, rows: Sequence[Sequence[float]]) -> list[TimedItem]:
        motions = (each.motion(rows[each.group]) for each in self._members[robot])
        return [TimedItem(tuple(islice(motions, len(each.motions))), each.curve) for each in self._items[robot]]

    def _path(self, robot: str, rows: Sequence[Sequence[float]]) -> PerformedPath:
        motions = [each.motion(rows[each.group]) for each in self._members[robot]]
        return PerformedPath(Pose(*rows[self._starts[robot]]), motions)

    def _columns(self, robot: str, tracked: TrackedRobot, tempo: int) -> tuple[dict[int, _Column], _Column]:
        """Return how the poses of a robot change with each unknown, and how far they are from its track: neighboring
        samples, for which their middle one stands, together."""
        track, timing, path = tracked.track, ItemTiming(self._items[robot]), self._path(robot, self._rows)
        places = [timing.at((sample.time - track[0].time) * tempo / 60) for sample in track]
        poses = [path.pose(*place) for place in places]
        missed = [differences(pose, sample.pose) for pose, sample in zip(poses, track, strict=True)]
        size = math.ceil(len(track) / _MAX_ROWS)
        firsts = range(0, len(track) - size + 1, size)
        means = [[sum(each) / size for each in zip(*missed[first : first + size], strict=True)] for first in firsts]
        middles = [first + size // 2 for first in firsts]
        meters, radians = (math.sqrt(size) / each for each in tracked.noise)
        weights = (meters, meters, meters, radians)
        used = {self._starts[robot], *(each.group for each in self._members[robot])}
        columns = {}
        for place, (row, at) in enumerate(self._unknowns):
            if row in used:
                rows = list(self._rows)
                rows[row] = [value + _NUDGE * (at == other) for other, value in enumerate(rows[row])]
                path = self._path(robot, rows)
                changes = [differences(poses[middle], path.pose(*places[middle])) for middle in middles]
                columns[place] = _column(changes, [weight / _NUDGE for weight in weights])
        return columns, _column(means, weights)


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
