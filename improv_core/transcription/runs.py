"""Splits a track where its path bends: into lines, arcs, and turns on the spot. Standard library only.

A run is a stretch with one geometry, at any speed. Fits don't use time, so a gentle start is no other run.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from improv_core.score.motion import Pose
from improv_core.transcription.track import Noise, Sample, Track

OUTLYING = 4.0
"""A pose may be this many standard deviations away from a run: of a thousand poses, none is farther by noise alone."""
TIGHTEST = 3e-4
"""Meters and radians that a pose may be away from a run however exact the track is."""


@dataclass(frozen=True, slots=True)
class StraightLine:
    """A line along which a robot moves without turning: progress is in meters from `middle`.

    `along` is the direction on the floor and `climb` the meters of height for each meter of progress; for a robot that
    goes straight up, `along` is 0 and `climb` 1.
    """

    middle: complex
    height: float
    along: complex
    climb: float
    heading: float

    def pose(self, progress: float) -> Pose:
        place = self.middle + self.along * progress
        return Pose(place.real, place.imag, self.height + self.climb * progress, self.heading)

    def progress(self, sample: Sample) -> float:
        if not self.along:
            return sample.z - self.height
        return ((complex(sample.x, sample.y) - self.middle) * self.along.conjugate()).real


@dataclass(frozen=True, slots=True)
class Arc:
    """A circle that a robot drives along, or a turn on the spot: progress is its heading in radians.

    Its place is `center + spoke * exp(i * heading)`. `climb` is in meters for each radian.
    """

    center: complex
    spoke: complex
    height: float
    climb: float
    by_place: bool

    def pose(self, progress: float) -> Pose:
        place = self.center + self.spoke * cmath.exp(1j * progress)
        return Pose(place.real, place.imag, self.height + self.climb * progress, progress)

    def progress(self, sample: Sample) -> float:
        if not self.by_place:
            return sample.heading
        seen = cmath.phase((complex(sample.x, sample.y) - self.center) / self.spoke)
        return sample.heading + math.remainder(seen - sample.heading, math.tau)


@dataclass(frozen=True, slots=True)
class PathRun:
    """Samples `first` to `last` of a track, both included, and the geometry that they keep to.

    `allowed` is how far, in units of progress, noise may take a sample along it.
    """

    first: int
    last: int
    geometry: StraightLine | Arc
    allowed: float


def runs_of(track: Track, noise: Noise) -> Iterator[PathRun]:
    """Yield the runs of a track one after another, each as long as it can be."""
    fits = _Fits(track, noise)
    first = 0
    while first < len(track) - 1:
        last = longest(first + 1, len(track) - 1, partial(fits.keeps, first))
        yield fits.run(first, last) or fits.forced(first, last)
        first = last


def runs_until(runs: Sequence[PathRun], last: int) -> list[PathRun]:
    """Return the runs of a track up to a sample."""
    return [replace(each, last=min(each.last, last)) for each in runs if each.first < last]


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


class _Fits:
    """Fits of one track's stretches, by running sums."""

    def __init__(self, track: Track, noise: Noise) -> None:
        self._track = track
        self._near = max(OUTLYING * noise.meters, TIGHTEST)
        self._turned = max(OUTLYING * noise.radians, TIGHTEST)
        self._by_place = noise.meters / noise.radians
        self._places = [complex(each.x, each.y) for each in track]
        self._spokes = [cmath.exp(1j * each.heading) for each in track]

    def keeps(self, first: int, last: int) -> bool:
        return self.run(first, last) is not None

    def forced(self, first: int, last: int) -> PathRun:
        """Return the nearest run to samples that keep to none."""
        run = self.run(first, last, always=True)
        assert run
        return run

    def run(self, first: int, last: int, always: bool = False) -> PathRun | None:
        """Return the run that these samples are; None if they keep to no line and no arc."""
        headings = [each.heading for each in self._track[first : last + 1]]
        if max(headings) - min(headings) <= 2 * self._turned:
            return self._line(first, last, always) or (None if last - first < 2 else self._arc(first, last, False))
        return self._arc(first, last, always)

    def _line(self, first: int, last: int, always: bool) -> PathRun | None:
        track, places = self._track[first : last + 1], self._places[first : last + 1]
        count = len(track)
        middle = sum(places) / count
        height = math.fsum(each.z for each in track) / count
        heading = math.fsum(each.heading for each in track) / count
        spread = sum((place - middle) ** 2 for place in places)  # its angle is twice that of the line
        along = cmath.exp(0.5j * cmath.phase(spread)) if spread else 1 + 0j
        if (places[-1] - places[0]).real * along.real + (places[-1] - places[0]).imag * along.imag < 0:
            along = -along
        steps = [((place - middle) * along.conjugate()).real for place in places]
        flat = max(steps) - min(steps)
        rises = max(each.z for each in track) - min(each.z for each in track)
        if flat <= self._near < rises:
            line = StraightLine(middle, height, 0j, 1.0, heading)
        else:
            square = math.fsum(step * step for step in steps)
            lifted = math.fsum(step * (each.z - height) for step, each in zip(steps, track, strict=True))
            climb = lifted / square if rises > self._near and square else 0.0
            line = StraightLine(middle, height, along, climb, heading)
        if not always and not all(self._keeps(line, each) for each in track):
            return None
        return PathRun(first, last, line, self._near)

    def _arc(self, first: int, last: int, always: bool) -> PathRun | None:
        track, places = self._track[first : last + 1], self._places[first : last + 1]
        spokes = self._spokes[first : last + 1]
        count = len(track)
        mean, turned = sum(places) / count, sum(spokes) / count
        cross = sum((p - mean) * (s - turned).conjugate() for p, s in zip(places, spokes, strict=True))
        square = math.fsum(abs(s - turned) ** 2 for s in spokes)
        spoke = cross / square if square else 0j
        height = math.fsum(each.z for each in track) / count
        heading = math.fsum(each.heading for each in track) / count
        rises = max(each.z for each in track) - min(each.z for each in track)
        climb = 0.0
        if rises > self._near:
            swept = math.fsum((each.heading - heading) ** 2 for each in track)
            climb = math.fsum((each.heading - heading) * (each.z - height) for each in track) / swept if swept else 0.0
        by_place = abs(spoke) > self._by_place and abs(spoke) > 1e-3
        arc = Arc(mean - spoke * turned, spoke, height - climb * heading, climb, by_place)
        if not always and not all(self._keeps(arc, each) for each in track):
            return None
        allowed = self._near / abs(spoke) if by_place else self._turned
        return PathRun(first, last, arc, allowed)

    def _keeps(self, geometry: StraightLine | Arc, sample: Sample) -> bool:
        """Return whether a sample lies on a geometry, up to noise."""
        there = geometry.pose(geometry.progress(sample))
        if isinstance(geometry, Arc) and abs(there.heading - sample.heading) > 2 * self._turned:
            return False
        far = math.dist((there.x, there.y, there.z), (sample.x, sample.y, sample.z))
        return far <= self._near
