"""Performs what was written, and compares it with the track. Standard library only."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import accumulate

from improv_core.score.motion import Pose
from improv_core.transcription.grouping import Grouped
from improv_core.transcription.rhythm import Gentle, Item
from improv_core.transcription.stretches import Amounts
from improv_core.transcription.track import Noise, Track

_WINDOW = 4
"""Noisy poses are compared in means of so many,"""
_NOISY = 1e-3
"""if their noise is at least this, in meters."""
_SHIFTS = (0.0, -0.5, 0.5, -1.0, 1.0)
"""Shares of the seconds by which a robot may be early or late."""
_STEPS = 3
"""The number of times that amounts are improved: each step nearly ends the error that is left."""
_MOST_UNKNOWNS = 60


class TranscribedPath:
    """Poses of a robot that performs motions one after another, some at a rate that changes."""

    def __init__(
        self, start: Pose, spans: Sequence[tuple[float, Callable[[float], float], Sequence[tuple[float, Amounts]]]]
    ) -> None:
        """Take spans: the beats of each, the beats of its body that it has played by then, and its body's motions."""
        self._ends: list[float] = []
        self._starts: list[Pose] = []
        self._spans = spans
        here, beat = start, 0.0
        for beats, _, motions in spans:
            self._starts.append(here)
            beat += beats
            self._ends.append(beat)
            for _, amounts in motions:
                here = here.then(amounts.pose())
        self._last = here

    def pose(self, beat: float) -> Pose:
        place = bisect_right(self._ends, beat)
        if place == len(self._spans):
            return self._last
        beats, played, motions = self._spans[place]
        here, left = self._starts[place], played(max(beat - (self._ends[place] - beats), 0.0))
        for length, amounts in motions:
            if left < length:
                return here.then(amounts.pose(left / length))
            here, left = here.then(amounts.pose()), left - length
        return here


def performance_of_items(start: Pose, items: Sequence[Item]) -> TranscribedPath:
    """Return the performance of items."""
    spans: list[tuple[float, Callable[[float], float], list[tuple[float, Amounts]]]] = []
    for item in items:
        motions = item.motions if isinstance(item, Gentle) else (item,)
        progress = item.curve.progress(item.beats) if isinstance(item, Gentle) else float
        spans.append((float(item.beats), progress, [(float(each.beats), each.amounts) for each in motions]))
    return TranscribedPath(start, spans)


def deviation_of(
    track: Track,
    start: Pose,
    items: Sequence[Item],
    tempo: int,
    noise: Noise,
    allowed: tuple[float, float, float],
) -> tuple[float, float]:
    """Return how far a performance is from a track at most, in meters and radians, if it may be early or
    late. Of a noisy track, means of neighboring poses count. `allowed` is in meters, radians, and seconds: nearer
    performances are not compared at other times."""
    performed = performance_of_items(start, items)
    origin = track[0].time
    window = window_of(track, noise)
    meters, radians, seconds = allowed
    best: list[tuple[float, float]] = []
    for shift in _SHIFTS:
        misses = []
        for sample in track:
            pose = performed.pose((sample.time - origin + shift * seconds) * tempo / 60)
            misses.append((sample.x - pose.x, sample.y - pose.y, sample.z - pose.z, sample.heading - pose.heading))
        sums = [list(accumulate(values, initial=0.0)) for values in zip(*misses, strict=True)]
        means = [[(each[at + window] - each[at]) / window for each in sums] for at in range(len(track) - window + 1)]
        apart = [(math.hypot(x, y, z), abs(yaw)) for x, y, z, yaw in means]
        best = apart if not best else [min(pair) for pair in zip(best, apart, strict=True)]
        if max(far for far, _ in best) <= meters and max(turned for _, turned in best) <= radians:
            break
    return max(far for far, _ in best), max(turned for _, turned in best)


def window_of(track: Track, noise: Noise) -> int:
    """Return the number of poses whose mean is compared with a performance."""
    return 1 if noise.meters < _NOISY else min(_WINDOW, len(track))


def refined(
    groups: Grouped, starts: Mapping[str, Pose], tracks: Mapping[str, Track], tempo: int
) -> tuple[Grouped, Mapping[str, Pose]]:
    """Return groups and start poses whose performance is nearest to the tracks, by least squares (Gauss-Newton)."""
    unknowns: list[tuple[int, int] | tuple[str, int]] = [
        (group, at) for group, amounts in enumerate(groups.amounts) for at in range(4) if amounts[at]
    ]
    if len(unknowns) > _MOST_UNKNOWNS:
        return groups, starts
    unknowns += [(robot, at) for robot in starts for at in range(4)]
    for _ in range(_STEPS):
        base = _seen(groups, starts, tracks, tempo)
        wanted = _wanted(tracks)
        columns = []
        for unknown in unknowns:
            other_groups, other_starts, robots = _nudged(groups, starts, unknown, _NUDGE)
            moved = _seen(other_groups, other_starts, {robot: tracks[robot] for robot in robots}, tempo)
            columns.append(
                {robot: [(b - a) / _NUDGE for a, b in zip(base[robot], moved[robot], strict=True)] for robot in robots}
            )
        missed = {robot: [w - b for w, b in zip(wanted[robot], base[robot], strict=True)] for robot in tracks}
        change = _solved(columns, missed)
        for unknown, value in zip(unknowns, change, strict=True):
            groups, starts, _ = _nudged(groups, starts, unknown, value)
    return groups, starts


_NUDGE = 1e-5
_EVERY = 400
"""So many samples of each robot are compared at most."""
_HEADING = 0.3
"""Meters that a radian counts for."""


def _picked(track: Track) -> Track:
    return track[:: max(1, len(track) // _EVERY)]


def _wanted(tracks: Mapping[str, Track]) -> dict[str, list[float]]:
    return {
        robot: [value for s in _picked(track) for value in (s.x, s.y, s.z, s.heading * _HEADING)]
        for robot, track in tracks.items()
    }


def _seen(
    groups: Grouped, starts: Mapping[str, Pose], tracks: Mapping[str, Track], tempo: int
) -> dict[str, list[float]]:
    found = {}
    for robot, track in tracks.items():
        performed = performance_of_items(starts[robot], groups.items(robot))
        origin = track[0].time
        poses = [performed.pose((sample.time - origin) * tempo / 60) for sample in _picked(track)]
        found[robot] = [value for p in poses for value in (p.x, p.y, p.z, p.heading * _HEADING)]
    return found


def _nudged(
    groups: Grouped, starts: Mapping[str, Pose], unknown: tuple[int, int] | tuple[str, int], by: float
) -> tuple[Grouped, Mapping[str, Pose], Sequence[str]]:
    """Return groups and starts with one value changed, and the robots that it concerns."""
    who, at = unknown
    if isinstance(who, str):
        pose = starts[who]
        values = [pose.x, pose.y, pose.z, pose.heading]
        values[at] += by
        return groups, {**starts, who: Pose(*values)}, [who]
    amounts = list(groups.amounts)
    values = list(amounts[who])
    values[at] += by
    amounts[who] = Amounts(*values)
    robots = [robot for robot, members in groups.members.items() if any(each.group == who for each in members)]
    return replace(groups, amounts=amounts), starts, robots


def _solved(columns: Sequence[Mapping[str, Sequence[float]]], missed: Mapping[str, Sequence[float]]) -> list[float]:
    """Return the least-squares change of the unknowns: the normal equations, by elimination."""
    count = len(columns)
    rows = []
    for one in columns:
        row = [math.fsum(_dot(one[robot], other[robot]) for robot in one if robot in other) for other in columns]
        row.append(math.fsum(_dot(one[robot], missed[robot]) for robot in one))
        rows.append(row)
    for at in range(count):
        rows[at][at] += 1e-9 + 1e-9 * rows[at][at]
    for at in range(count):
        pivot = max(range(at, count), key=lambda row: abs(rows[row][at]))
        rows[at], rows[pivot] = rows[pivot], rows[at]
        for other in range(at + 1, count):
            factor = rows[other][at] / rows[at][at]
            if factor:
                rows[other] = [b - factor * a for a, b in zip(rows[at], rows[other], strict=True)]
    found = [0.0] * count
    for at in reversed(range(count)):
        found[at] = (rows[at][-1] - math.fsum(rows[at][k] * found[k] for k in range(at + 1, count))) / rows[at][at]
    return found


def _dot(one: Sequence[float], other: Sequence[float]) -> float:
    return sum(map(float.__mul__, one, other))
