"""Splits runs where their speed changes: into stretches of one velocity each. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, zip_longest
from typing import NamedTuple

from improv_core.score.motion import Pose, Twist
from improv_core.transcription.runs import PathRun, longest
from improv_core.transcription.track import Track

_ARM = 0.5
"""Meters: a turn by an angle counts like a way of this length times the angle."""
_MEETING = 7e-4
"""Meters: paces meet if their poses come as near as this, or as noise allows."""
_THIRDS = 30
"""Each leaves out a third of the time in which two stretches may meet."""


class Amounts(NamedTuple):
    """All that a robot moves in a stretch, in its own frame: meters forward, left, and up, and radians of turn.

    Over any part of the time, it moves that part of these.
    """

    x: float
    y: float
    z: float
    yaw: float

    def pose(self, share: float = 1.0) -> Pose:
        """Return the pose after a share of the stretch, from its start."""
        return Pose().after(Twist(*self), share)


def amounts_between(one: Pose, other: Pose, turn: float) -> Amounts:
    """Return the constant motion from one pose to the other that turns by `turn` radians in all.

    It is the logarithm of the displacement (Lynch & Park, Modern Robotics, 3.3.3).
    """
    moved = one.inverse().then(other)
    half = turn / 2
    shrink = 1.0 if abs(half) < 1e-9 else half / math.sin(half) if abs(math.sin(half)) > 1e-9 else math.inf
    if math.isinf(shrink):  # whole circles: the way is not in the displacement
        return Amounts(0.0, 0.0, moved.z, turn)
    way = complex(moved.x, moved.y) * complex(math.cos(half), -math.sin(half)) * shrink
    return Amounts(way.real, way.imag, moved.z, turn)


@dataclass(frozen=True, slots=True)
class EvenStretch:
    """A span of time, in seconds, in which a robot keeps one velocity. `run` numbers the geometry that it is on."""

    start: float
    end: float
    amounts: Amounts
    run: int

    @property
    def seconds(self) -> float:
        return self.end - self.start


class _Pace(NamedTuple):
    """Even progress along a run, from a sample to another: `progress` at `time`, and units per second."""

    first: int
    last: int
    time: float
    progress: float
    rate: float
    run: PathRun
    number: int

    def at(self, time: float) -> float:
        return self.progress + self.rate * (time - self.time)

    def pose(self, time: float) -> Pose:
        return self.run.geometry.pose(self.at(time))


def stretches_of(track: Track, runs: Sequence[PathRun], most: float = math.inf) -> list[EvenStretch]:
    """Return the stretches of a track with these runs, without gaps, from its first to its last sample; none if there
    are more than `most`."""
    if len(runs) > 2 * most:  # between two long runs, one may be left out
        return []
    paces = _without_mixed(track, [pace for number, run in enumerate(runs) for pace in _paces(track, run, number)])
    if len(paces) > most:
        return []
    times = [track[0].time, *(_meeting(track, *both) for both in pairwise(paces)), track[-1].time]
    for place in range(1, len(times)):  # a meeting may not come before the one before it
        times[place] = max(times[place], times[place - 1])
    found = [_stretch(pace, *span) for pace, span in zip(paces, pairwise(times), strict=True)]
    return [stretch for stretch in found if stretch.end > stretch.start]


def _without_mixed(track: Track, paces: Sequence[_Pace]) -> list[_Pace]:
    """Leave out paces between two samples in which a robot changes from the pace before to the one after."""
    kept: list[_Pace] = []
    for here, after in zip_longest(paces, paces[1:]):
        if kept and after and _samples(here, None) == 1 and min(_samples(each, here) for each in (kept[-1], after)) > 1:
            time = _meeting(track, kept[-1], after)
            if _apart(kept[-1].pose(time), after.pose(time)) <= max(_MEETING, here.run.allowed) ** 2:
                continue
        kept.append(here)
    return kept


def _samples(pace: _Pace, beside: _Pace | None) -> int:
    """Return the intervals between samples of a pace; of its whole run, if it is beside a pace of another run."""
    whole = beside is not None and beside.number != pace.number
    return pace.run.last - pace.run.first if whole else pace.last - pace.first


def _stretch(pace: _Pace, start: float, end: float) -> EvenStretch:
    one, other = pace.pose(start), pace.pose(end)
    turn = other.heading - one.heading
    if abs(math.sin(turn / 2)) < 1e-3 < abs(turn):  # about a whole circle: measure half of it
        middle = pace.pose((start + end) / 2)
        half = amounts_between(one, middle, middle.heading - one.heading)
        return EvenStretch(start, end, Amounts(half.x * 2, half.y * 2, half.z * 2, turn), pace.number)
    return EvenStretch(start, end, amounts_between(one, other, turn), pace.number)


def _paces(track: Track, run: PathRun, number: int) -> Iterator[_Pace]:
    """Yield the stretches of a run with an even pace, each as long as it can be."""
    progress = [run.geometry.progress(each) for each in track[run.first : run.last + 1]]
    times = [each.time for each in track[run.first : run.last + 1]]
    first, most = 0, len(times) - 1
    while first < most:

        def fits(end: int, first: int = first) -> bool:
            return _fit(times, progress, first, end, run.allowed) is not None

        last = longest(first + 1, most, fits)
        time, at, rate = _fit(times, progress, first, last, run.allowed) or _fit(times, progress, first, last, math.inf)  # type: ignore[misc]
        yield _Pace(run.first + first, run.first + last, time, at, rate, run, number)
        first = last


def _fit(
    times: Sequence[float], progress: Sequence[float], first: int, last: int, allowed: float
) -> tuple[float, float, float] | None:
    """Return the mean time, the progress then, and the rate of these samples; None if one is farther than `allowed`."""
    when, seen = times[first : last + 1], progress[first : last + 1]
    count = len(when)
    time, mean = math.fsum(when) / count, math.fsum(seen) / count
    square = math.fsum((t - time) ** 2 for t in when)
    rate = math.fsum((t - time) * (s - mean) for t, s in zip(when, seen, strict=True)) / square if square else 0.0
    if any(abs(mean + rate * (t - time) - s) > allowed for t, s in zip(when, seen, strict=True)):
        return None
    return time, mean, rate


def _meeting(track: Track, one: _Pace, other: _Pace) -> float:
    """Return the time at which one pace gives way to the next: where their poses come nearest, near the sample that
    both share."""
    low = track[max(one.last - 1, one.first)].time
    high = track[min(other.first + 1, other.last)].time
    return _least(lambda time: _apart(one.pose(time), other.pose(time)), low, high)


def _apart(one: Pose, other: Pose) -> float:
    return (
        (one.x - other.x) ** 2
        + (one.y - other.y) ** 2
        + (one.z - other.z) ** 2
        + (_ARM * math.remainder(one.heading - other.heading, math.tau)) ** 2
    )


def _least(cost: Callable[[float], float], low: float, high: float) -> float:
    """Return where a function with one valley is least."""
    for _ in range(_THIRDS):
        third = (high - low) / 3
        if cost(low + third) <= cost(high - third):
            high -= third
        else:
            low += third
    return (low + high) / 2
