"""Splits a track where its velocity changes: into stretches of one velocity each. Standard library only."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise, zip_longest

from improv_core.transcription.amounts import Amounts, amounts_between
from improv_core.transcription.fits import FittedVelocity, VelocityFits, cheapest, longest
from improv_core.transcription.track import Track

_COARSE = 4
"""The search for changes first takes one in this many samples, and then all samples near those it found."""
_STEPS = 18
"""The number of steps to where two stretches meet: each leaves half of the time in which they may."""
_NUDGE = 1e-6
"""Seconds to the poses that show on which side they meet."""


@dataclass(frozen=True, slots=True)
class EvenStretch:
    """A span of time, in seconds, in which a robot keeps one velocity: its `amounts` in each second."""

    start: float
    end: float
    amounts: Amounts

    @property
    def seconds(self) -> float:
        return self.end - self.start


def stretches_of(fits: VelocityFits) -> list[EvenStretch]:
    """Return the stretches that describe a track in the fewest amounts, from its first to its last sample."""
    times = fits.times
    steps = _steps_between(fits, [*range(0, len(times) - 1, _COARSE), len(times) - 1])
    near = {end + off for step in steps for end in step for off in range(1 - _COARSE, _COARSE)}
    steps = _steps_between(fits, sorted(near.intersection(range(len(times)))))
    found: list[tuple[int, int, FittedVelocity]] = []
    for (first, last), after in zip_longest(steps, steps[1:]):
        if found and after and last - first == 1:  # between two samples, a robot changes from one to the other
            one, other = found[-1][2], fits.fit(after[0], after[1] + 1)
            if _apart(one, other, _meeting(one, other, times[first], times[last])) <= fits.near:
                continue
        found.append((first, last, fits.fit(first, last + 1)))
    ends = [times[0]]
    for (_, last, one), (first, _, other) in pairwise(found):
        low, high = times[max(last - 1, 0)], times[min(first + 1, len(times) - 1)]
        ends.append(max(_meeting(one, other, low, high), ends[-1]))
    ends.append(times[-1])
    return [
        EvenStretch(*span, each.velocity)
        for (_, _, each), span in zip(found, pairwise(ends), strict=True)
        if span[0] < span[1]
    ]


def _steps_between(fits: VelocityFits, nodes: Sequence[int]) -> list[tuple[int, int]]:
    """Return the samples, all among these, at which the stretches that describe a track best begin and end."""
    _, steps = cheapest(fits.edges([fits.times[node] for node in nodes], [0.0] * len(nodes)))
    return [(nodes[first], nodes[last]) for first, last, _ in steps]


def chained(track: Track, meters: float, radians: float) -> Iterator[EvenStretch]:
    """Yield stretches from sample to sample that are so near to all samples between them, however many there are."""
    first = 0
    while first < len(track) - 1:
        joins = partial(_joins, track, first, meters, radians)
        last = longest(first + 1, len(track) - 1, joins)
        one, other = track[first], track[last]
        amounts = amounts_between(one.pose, other.pose, other.heading - one.heading)
        seconds = other.time - one.time
        yield EvenStretch(one.time - track[0].time, other.time - track[0].time, amounts.times(1 / seconds))
        first = last


def _joins(track: Track, first: int, meters: float, radians: float, last: int) -> bool:
    """Return whether the samples between two are near those of one motion from the first to the last one."""
    one, other = track[first], track[last]
    amounts = amounts_between(one.pose, other.pose, other.heading - one.heading)
    for sample in track[first + 1 : last]:
        there = one.pose.then(amounts.pose((sample.time - one.time) / max(other.time - one.time, 1e-9)))
        far = math.dist((there.x, there.y, there.z), (sample.x, sample.y, sample.z))
        if far > meters or abs(there.heading - sample.heading) > radians:
            return False
    return True


def _apart(one: FittedVelocity, other: FittedVelocity, time: float) -> float:
    far, turned = one.pose(time).apart(other.pose(time))
    return far + turned / 2


def _meeting(one: FittedVelocity, other: FittedVelocity, low: float, high: float) -> float:
    """Return the time at which both poses come nearest."""
    for _ in range(_STEPS):
        middle = (low + high) / 2
        if _apart(one, other, middle - _NUDGE) <= _apart(one, other, middle + _NUDGE):
            high = middle
        else:
            low = middle
    return (low + high) / 2
