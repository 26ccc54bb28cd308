"""Fits the fewest stretches of one velocity each to a noisy track, by dynamic programming. Standard library only."""

from __future__ import annotations

import cmath
import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import accumulate
from operator import mul
from typing import Any, Generic, NamedTuple, TypeVar

from improv_core.score.motion import Pose, Twist
from improv_core.transcription.amounts import Amounts
from improv_core.transcription.track import Noise, Track

_STRETCH_COST = 7.0
"""Natural units of information that another stretch costs, besides its amounts: its end and its word."""
_AMOUNT_COST = 3.0
"""The cost of each amount that isn't 0."""
_CLEAR = 2.5
"""An amount of fewer standard deviations is 0."""
_WORST, _HOPELESS = 4.5, 80.0
"""The most variances of a fit: for each sample, and once. A stretch with more is split."""
_USUAL, _GOOD = 3.5, 10.0
"""The variances, counted likewise, up to which a fit is as good as noise allows."""
_BACK = 24
"""The most nodes by which a stretch may end before the last one up to which its fit is that good."""

Content = TypeVar("Content")


class TrackEdge(NamedTuple, Generic[Content]):
    """A description of the track from a node to the node `end`, and its cost in natural units of information."""

    end: int
    cost: float
    content: Content


def cheapest(edges: Sequence[Iterable[TrackEdge[Content]]]) -> tuple[float, list[tuple[int, int, Content]]]:
    """Return the cost of the cheapest way from the first to the last node, and its edges, with the nodes of each.

    `edges` holds those that begin at each node but the last. If none reaches the last node, the way ends before it.
    """
    costs = [0.0] + [math.inf] * len(edges)
    before: list[tuple[int, int, Content] | None] = [None] * len(costs)
    for place, begun in enumerate(edges):
        if costs[place] < math.inf:
            for end, cost, content in begun:
                if costs[place] + cost < costs[end]:
                    costs[end], before[end] = costs[place] + cost, (place, end, content)
    last = max(place for place, cost in enumerate(costs) if cost < math.inf)
    total, found = costs[last], []
    while step := before[last]:
        found.append(step)
        last = step[0]
    return total, found[::-1]


def longest(least: int, most: int, fits: Callable[[int], bool]) -> int:
    """Return the greatest end that fits, by doubling and halving; `least` if nothing does."""
    good, step = least, 1
    while good < most and fits(min(good + step, most)):
        good = min(good + step, most)
        step *= 2
    bad = min(good + step, most + 1)
    while bad - good > 1:
        middle = (good + bad) // 2
        good, bad = (middle, bad) if fits(middle) else (good, middle)
    return good


class FittedVelocity(NamedTuple):
    """A velocity for some samples of a track.

    `misfit` is their distance from it, as a sum of squares in variances; `middle` is the pose at the mean `time`: x, y,
    z, and heading; `velocity` has the amounts of each second.
    """

    misfit: float
    time: float
    middle: tuple[float, float, float, float]
    velocity: Amounts

    def pose(self, time: float) -> Pose:
        return Pose(*self.middle).after(Twist(*self.velocity), time - self.time)


class VelocityFits:
    """Fits of constant velocities to a noisy track, by running sums."""

    def __init__(self, track: Track, noise: Noise, times: Sequence[float] | None = None) -> None:
        """Take a track, and other `times` for its samples if it is to be played at a rate that changes."""
        self.times = times or [each.time - track[0].time for each in track]
        self._noise = noise
        self._origin = track[0]
        self._places = [complex(each.x - track[0].x, each.y - track[0].y) for each in track]
        self._time = _sums(self.times)
        self._square = _sums(time * time for time in self.times)
        self._heading = _Sums(self.times, [each.heading - track[0].heading for each in track])
        self._height = _Sums(self.times, [each.z - track[0].z for each in track])
        self._place = _Sums(self.times, self._places)

    def edges(self, nodes: Sequence[float], parts: Sequence[float]) -> list[Iterable[TrackEdge[Amounts]]]:
        """Return the stretches that begin at each node but the last, each found when it is asked for: nodes are times,
        and an end there costs `parts`."""
        firsts = [bisect_left(self.times, time - 1e-9) for time in nodes]
        pasts = [bisect_right(self.times, time + 1e-9) for time in nodes]
        last = len(nodes) - 1

        def begun(place: int) -> Iterator[TrackEdge[Amounts]]:
            first, fit = firsts[place], None
            good = longest(place + 1, last, lambda end: self._keeps(first, pasts[end]))
            for end in range(max(place + 1, good - _BACK), last + 1):
                past = pasts[end]
                if past - first < 2:
                    if end == last:  # nothing is left to describe
                        yield TrackEdge(end, 0.0, Amounts())
                    continue
                fit = self._fit_within(first, past, _WORST * (past - first) + _HOPELESS if fit else math.inf)
                if fit is None:
                    break
                known = sum(map(bool, fit.velocity))
                word = _STRETCH_COST + parts[end] if known or end < last else 0.0  # a robot stands at the end anyway
                cost = fit.misfit / 2 + word + _AMOUNT_COST * known
                yield TrackEdge(end, cost, fit.velocity.times(nodes[end] - nodes[place]))

        return [begun(place) for place in range(last)]

    def _keeps(self, first: int, past: int) -> bool:
        return past - first < 3 or self._fit_within(first, past, _USUAL * (past - first) + _GOOD) is not None

    @property
    def near(self) -> float:
        """Meters that poses may be apart by noise alone."""
        return 4 * (self._noise.meters + self._noise.radians / 2)

    def fit(self, first: int, past: int) -> FittedVelocity:
        """Return the velocity of these samples, of which there are at least two."""
        fit = self._fit_within(first, past, math.inf)
        assert fit
        return fit

    def _fit_within(self, first: int, past: int, limit: float) -> FittedVelocity | None:
        """Return the same; None if its misfit is over a limit."""
        count = past - first
        mean = (self._time[past] - self._time[first]) / count
        spread = max(self._square[past] - self._square[first] - count * mean * mean, 1e-12)
        meters, radians = self._noise
        wide = math.sqrt(spread)
        heading, turn, turned = self._heading.line(first, past, mean, spread)
        rate = turn.real
        if abs(rate) * wide <= _CLEAR * radians:
            turned, rate = turned + rate * rate * spread, 0.0
        height, rise, lifted = self._height.line(first, past, mean, spread)
        if abs(rise) * wide <= _CLEAR * meters:
            lifted, rise = lifted + abs(rise) ** 2 * spread, 0j
        misfit = lifted / meters**2 + turned / radians**2
        if misfit > limit:
            return None
        if not rate:
            place, speed, missed = self._place.line(first, past, mean, spread)
        else:
            back = [cmath.rect(1.0, rate * (mean - time)) for time in self.times[first:past]]
            way, (middle, total) = sum(back).conjugate() / count, self._place.spread(first, past)
            square = max(count - count * abs(way) ** 2, 1e-12)
            spoke = (sum(map(mul, self._places[first:past], back)) - count * middle * way.conjugate()) / square
            missed = max(total - abs(spoke) ** 2 * square, 0.0)
            place, speed = middle - spoke * (way - 1), spoke * 1j * rate
            wide = math.sqrt(square) / abs(rate)
        misfit += missed / meters**2
        if misfit > limit:
            return None
        facing = heading.real + self._origin.heading
        body = speed * cmath.exp(-1j * facing)
        aside = max(meters / wide, abs(speed) * radians / math.sqrt(count))
        velocity = Amounts(
            body.real if abs(body.real) * wide > _CLEAR * meters else 0.0,
            body.imag if abs(body.imag) > _CLEAR * aside else 0.0,
            rise.real,
            rate,
        )
        origin = self._origin
        middle_pose = (place.real + origin.x, place.imag + origin.y, height.real + origin.z, facing)
        return FittedVelocity(misfit, mean, middle_pose, velocity)


class _Sums:
    """Running sums of values over time, and the straight lines that fit them."""

    def __init__(self, times: Sequence[float], values: Sequence[complex]) -> None:
        self._value = _sums(values)
        self._mixed = _sums(t * v for t, v in zip(times, values, strict=True))
        self._square = _sums(v.real * v.real + v.imag * v.imag for v in values)

    def line(self, first: int, past: int, mean: float, spread: float) -> tuple[complex, complex, float]:
        """Return the mean of these values, their slope, and the sum of squares that is left."""
        if not self._square[-1]:  # on the floor
            return 0.0, 0.0, 0.0
        value, square = self.spread(first, past)
        slope = (self._mixed[past] - self._mixed[first] - (past - first) * mean * value) / spread
        return value, slope, max(square - abs(slope) ** 2 * spread, 0.0)

    def spread(self, first: int, past: int) -> tuple[complex, float]:
        """Return the mean of these values, and the sum of squares of their distances from it."""
        count = past - first
        value = (self._value[past] - self._value[first]) / count
        return value, self._square[past] - self._square[first] - count * abs(value) ** 2


def _sums(values: Iterable[complex]) -> list[Any]:
    return list(accumulate(values, initial=0.0))
