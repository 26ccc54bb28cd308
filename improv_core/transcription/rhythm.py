"""Puts a robot's stretches on the beats, and finds those that begin and end gently. Standard library only."""

from __future__ import annotations

import cmath
import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import accumulate, pairwise
from typing import NamedTuple, TypeAlias

from improv_core.score.algebra import stand
from improv_core.score.ramps import Stepped, ease, ramp
from improv_core.transcription.runs import PathRun, runs_of, runs_until
from improv_core.transcription.stretches import Amounts, EvenStretch, stretches_of
from improv_core.transcription.tempo import on_grid
from improv_core.transcription.track import Noise, Track

_GRID = (1, 2, 3, 4)
"""Noisy changes are taken to be on these parts of a beat,"""
_FINE_GRID = (3, 8)
"""or on these, if that is too far off."""
_STRETCH_COST = 12.0
"""Natural units of information that another stretch costs: its amounts, and its end on a beat."""
_PART_COST = {1: 0.0, 2: 2.0, 3: 4.0, 4: 4.0, 8: 6.0}
"""The further cost of an end on such a part of a beat."""
_WORST = 9.0
"""The mean square of a fit, in variances, above which no longer stretch is tried."""
_FEWEST = 3
"""The fewest stretches that may be one gentle movement: its beginning, its middle, and its end."""
_MOST_GENTLE = 32
"""The most beats of a gentle movement."""
_EXACT = 1e-6
"""Seconds by which a sample may be off and still be at a beat."""
_STANDING = 1e-2
"""A robot stands if it is slower than this share of its speed before."""
_GROWTH = 1.2
"""From its first step to the end of its first quarter, an `ease` grows by more than this factor."""
_LATER = 1 + 1 / 16
"""The quarter of a movement is taken to be this much longer, since a stretch's ends are not exact."""
_RATIOS = sorted({Fraction(part, parts) for parts in (1, 2, 3, 4, 5, 6, 8) for part in range(parts + 1)})
"""The parts of both rates of a `ramp` that its first one may be."""


@dataclass(frozen=True, slots=True)
class TimedMotion:
    """A number of beats with one velocity, in which a robot moves by `amounts`."""

    beats: Fraction
    amounts: Amounts


class RateCurve(NamedTuple):
    """The rate of a gentle movement: `ease`, or `ramp` from one rate to another, which add up to 2."""

    start: Fraction | None = None

    @property
    def stops(self) -> bool:
        """True if a robot is at rest at its end."""
        return self.start is None or self.start == 2

    @property
    def end(self) -> Fraction:
        assert self.start is not None
        return 2 - self.start

    def progress(self, beats: Fraction) -> Callable[[float], float]:
        """Return a function of beats: those of a body of so many beats that this curve has played by then."""
        made = ease(stand(beats)) if self.start is None else ramp(stand(beats), self.start, self.end)
        assert isinstance(made, Stepped)
        steps = list(made.steps_from(0, False))
        ends = [0.0, *accumulate(float(each.beats) for each in steps)]
        reached = [0.0, *accumulate(float(each.beats * each.rate) for each in steps)]

        def played(beat: float) -> float:
            step = min(max(bisect_right(ends, beat) - 1, 0), len(steps) - 1)
            return reached[step] + (beat - ends[step]) * float(steps[step].rate)

        return played


@dataclass(frozen=True, slots=True)
class Gentle:
    """Motions at a rate that changes along a curve."""

    curve: RateCurve
    motions: tuple[TimedMotion, ...]

    @property
    def beats(self) -> Fraction:
        return sum((each.beats for each in self.motions), Fraction(0))


Item: TypeAlias = TimedMotion | Gentle


@dataclass(frozen=True)
class OnBeats:
    """A stretch on the beats."""

    start: Fraction
    end: Fraction
    stretch: EvenStretch

    @cached_property
    def span(self) -> tuple[float, float]:
        """The beats at which it begins and ends, for quick comparisons."""
        return float(self.start), float(self.end)

    @cached_property
    def rate(self) -> float:
        """The robot's speed, in meters and radians per beat."""
        return math.hypot(*self.stretch.amounts) / (self.span[1] - self.span[0])


class TrackedRobot(NamedTuple):
    """A robot's track and its stretches. `allowed` is how many seconds a change may be off."""

    track: Track
    noise: Noise
    noisy: bool
    allowed: float
    stretches: Sequence[EvenStretch]


def items_of(robot: TrackedRobot, tempo: int, gently: bool = True) -> Sequence[Item]:
    """Return what a robot performs, beat 0 being its first sample. Gentle movements are found if they are to be."""
    track, noise, noisy, allowed, stretches = robot
    if noisy:
        placed = on_coarse_grid(track, noise, tempo, _GRID if gently else _FINE_GRID)
    else:
        placed = _placed(stretches, track[0].time, tempo, allowed)
    if gently:
        return list(_gentle(track, placed, noise, tempo))
    return [TimedMotion(each.end - each.start, each.stretch.amounts) for each in placed]


def _placed(stretches: Sequence[EvenStretch], origin: float, tempo: float, allowed: float) -> list[OnBeats]:
    ends = [on_grid(each.end - origin, tempo, allowed) for each in stretches]
    starts = [Fraction(0), *ends]
    return [OnBeats(*span) for span in zip(starts, ends, stretches, strict=False) if span[0] < span[1]]


def on_coarse_grid(track: Track, noise: Noise, tempo: int, grid: Sequence[int] = _GRID) -> list[OnBeats]:
    """Return stretches whose ends lie on simple parts of beats: those that tell a noisy track in the fewest words.

    This is a shortest path: a stretch costs how badly it fits, in natural units, and what it takes to write it.
    """
    origin, seconds = track[0].time, 60 / tempo
    last = Fraction(math.ceil((track[-1].time - origin) / seconds - 0.05))
    nodes = sorted({Fraction(place, parts) for parts in grid for place in range(int(last * parts) + 1)})
    times = [each.time - origin for each in track]
    fits = _Fits(track, noise)
    costs: list[float] = [0.0] + [math.inf] * (len(nodes) - 1)
    before: list[tuple[int, Amounts]] = [(0, Amounts(0, 0, 0, 0))] * len(nodes)
    for place, start in enumerate(nodes):
        if costs[place] == math.inf:
            continue
        bad = 0
        first = bisect_left(times, float(start) * seconds - 1e-9)
        for other in range(place + 1, len(nodes)):
            end = nodes[other]
            past = bisect_right(times, float(end) * seconds + 1e-9)
            if past - first < 3 and (other == place + 1 or past < len(times)):
                continue
            fit = fits.constant(
                first,
                max(past, min(first + 3, len(times))),
                float(start) * seconds + origin,
                float(end) * seconds + origin,
            )
            if fit is None:
                continue
            misfit, amounts = fit
            bad = bad + 1 if misfit > _WORST * 3 * (past - first) else 0
            if bad > 4 and end - start > 1:
                break
            cost = costs[place] + misfit / 2 + _STRETCH_COST + _PART_COST[end.denominator]
            if cost < costs[other]:
                costs[other], before[other] = cost, (place, amounts)
    found, place = [], len(nodes) - 1
    while place and costs[place] == math.inf:
        place -= 1
    while place:
        first, amounts = before[place]
        since, until = (float(nodes[at]) * seconds + origin for at in (first, place))
        found.append(OnBeats(nodes[first], nodes[place], EvenStretch(since, until, amounts, 0)))
        place = first
    return found[::-1]


class _Fits:
    """Fits of constant velocities to a noisy track."""

    def __init__(self, track: Track, noise: Noise) -> None:
        self._track = track
        self._noise = noise
        self._places = [complex(each.x, each.y) for each in track]

    def constant(self, first: int, past: int, start: float, end: float) -> tuple[float, Amounts] | None:
        """Return how far these samples are from one velocity, as a sum of squares in variances, and what a robot moves
        at it from `start` to `end`; None if there are too few."""
        track, places = self._track[first:past], self._places[first:past]
        count = len(track)
        if count < 2:
            return None
        times = [each.time - start for each in track]
        mean = math.fsum(times) / count
        square = math.fsum((time - mean) ** 2 for time in times)
        heading = math.fsum(each.heading for each in track) / count
        rate = math.fsum((t - mean) * each.heading for t, each in zip(times, track, strict=True)) / square
        turned = math.fsum(
            (each.heading - heading - rate * (t - mean)) ** 2 for t, each in zip(times, track, strict=True)
        )
        height = math.fsum(each.z for each in track) / count
        rise = math.fsum((t - mean) * each.z for t, each in zip(times, track, strict=True)) / square
        lifted = math.fsum((each.z - height - rise * (t - mean)) ** 2 for t, each in zip(times, track, strict=True))
        ways = times if abs(rate) < 1e-6 else [(cmath.exp(1j * rate * t) - 1) / (1j * rate) for t in times]
        middle, way = sum(places) / count, sum(ways) / count
        spread = math.fsum(abs(w - way) ** 2 for w in ways)
        speed = sum((p - middle) * (w - way).conjugate() for p, w in zip(places, ways, strict=True)) / spread
        missed = math.fsum(abs(p - middle - speed * (w - way)) ** 2 for p, w in zip(places, ways, strict=True))
        seconds = end - start
        body = speed * cmath.exp(-1j * (heading - rate * mean)) * seconds
        misfit = (missed + lifted) / self._noise.meters**2 + turned / self._noise.radians**2
        return misfit, Amounts(body.real, body.imag, rise * seconds, rate * seconds)


def _gentle(track: Track, placed: Sequence[OnBeats], noise: Noise, tempo: int) -> Iterator[Item]:
    """Yield the placed stretches, with gentle movements in place of those that they consist of."""
    found: list[tuple[Fraction, Item | OnBeats]] = []  # with the beat at which each begins
    left, end = list(placed), placed[-1].end
    loose = _sample_beats(track, tempo)
    while left:
        start = _loosely(left[0].start, loose)
        gentle = _gentle_at(track, left, start, noise, tempo) if start is not None else None
        if gentle and start is not None:
            found.append((start, gentle))
            left = _from(left, start + gentle.beats, loose if gentle.curve.stops else Fraction(0))
            end = max(end, start + gentle.beats)
        else:
            found.append((left[0].start, left[0]))
            left.pop(0)
    starts = [*(start for start, _ in found), end]
    for (start, item), after in zip(found, starts[1:], strict=True):
        if not isinstance(item, OnBeats):
            yield item
        elif after > start:
            yield TimedMotion(after - start, item.stretch.amounts)


def _sample_beats(track: Track, tempo: int) -> Fraction:
    """Return the usual number of beats between two samples: the ends of short stretches are known no better."""
    steps = sorted(after.time - here.time for here, after in pairwise(track))
    return Fraction(steps[len(steps) // 2] * 1.01 * tempo / 60)


def _loosely(beat: Fraction, loose: Fraction) -> Fraction | None:
    """Return the simple part of a beat that is nearest, if it is near enough."""
    near = [Fraction(round(beat * parts), parts) for parts in _GRID]
    return next((each for each in near if abs(each - beat) <= loose), None)


def _from(placed: Sequence[OnBeats], beat: Fraction, loose: Fraction) -> list[OnBeats]:
    """Return what is left of stretches from a beat on, where the first of them then begins."""
    left = [each for each in placed if each.end > beat + loose]
    if left and left[0].start < beat and (share := (left[0].end - beat) / (left[0].end - left[0].start)) < 1:
        amounts = Amounts(*(amount * float(share) for amount in left[0].stretch.amounts))
        left[0] = replace(left[0], stretch=replace(left[0].stretch, amounts=amounts))
    return [replace(left[0], start=beat), *left[1:]] if left else []


def _gentle_at(track: Track, placed: Sequence[OnBeats], start: Fraction, noise: Noise, tempo: int) -> Gentle | None:
    """Return the longest gentle movement that the first of these stretches begin."""
    if len(placed) < _FEWEST or placed[0].rate == placed[1].rate:
        return None
    loose = _sample_beats(track, tempo)
    likely = [*_eases(placed, loose), *_ramps(placed, loose)]
    likely = [(end - start, stretches, curve) for end, stretches, curve in likely if 0 < end - start <= _MOST_GENTLE]
    if not likely:
        return None
    seconds = 60 / tempo
    origin, longest = track[0].time + float(start) * seconds, max(beats for beats, _, _ in likely)
    within = _until([each for each in track if each.time >= origin - _EXACT], origin + float(longest) * seconds)
    runs = list(runs_of(within, noise))
    for beats, stretches, curve in likely:
        passed = _until(within, origin + float(beats) * seconds)
        motions = _unwarped(passed, runs, origin, seconds, beats, curve, stretches // _FEWEST)
        if motions and sum(each.beats for each in motions) == beats:
            return Gentle(curve, motions)
    return None


def _until(track: Track, time: float) -> Track:
    return track[: bisect_right(track, time + _EXACT, key=lambda each: each.time)]


def _eases(placed: Sequence[OnBeats], loose: Fraction) -> Iterator[tuple[Fraction, int, RateCurve]]:
    """Yield where an `ease` may end, the latest first, and of how many stretches it would be made."""
    if not placed[0].rate < placed[1].rate:
        return
    start, _ = placed[0].span
    latest = bisect_right(placed, start + _MOST_GENTLE, key=lambda each: each.span[1])
    for last in range(latest - 1, _FEWEST - 2, -1):
        if _slowest(placed, last) and _swells(placed, last):
            end = _loosely(placed[last].end, loose)
            if end is not None:
                yield end, last + 1, RateCurve()


def _swells(placed: Sequence[OnBeats], last: int) -> bool:
    """Return whether the rate rises in the first quarter and falls in the last one."""
    start, end = placed[0].span[0], placed[last].span[1]
    quarter = (end - start) / 4 * _LATER
    late = bisect_left(placed, end - quarter, hi=last, key=lambda each: each.span[0])
    early = bisect_right(placed, start + quarter, key=lambda each: each.span[1])
    first, final = placed[1].stretch.run, placed[last - 1].stretch.run  # the outermost may be where a robot changes
    rising = [each.rate for each in placed[: early + 1] if each.stretch.run == first]
    falling = [each.rate for each in placed[last : max(late - 2, 0) : -1] if each.stretch.run == final]
    return _rises(rising) and _rises(falling)


def _rises(rates: Sequence[float]) -> bool:
    steady = all(here < after * _GROWTH for here, after in pairwise(rates))
    return len(rates) > 1 and steady and rates[0] * _GROWTH < max(rates)


def _slowest(placed: Sequence[OnBeats], last: int) -> bool:
    """Return whether a robot does not go on slowing down after this stretch."""
    if last + 1 == len(placed) or placed[last].stretch.run != placed[last + 1].stretch.run:
        return True
    here, after = placed[last].rate, placed[last + 1].rate
    return here <= after * (1 + _STANDING) or after < _STANDING * here


def _ramps(placed: Sequence[OnBeats], loose: Fraction) -> Iterator[tuple[Fraction, int, RateCurve]]:
    """Yield where a `ramp` may end, the latest first, of how many stretches it would be made, and its rates."""
    way = 1 if placed[1].rate > placed[0].rate else -1
    last = 1
    while last < len(placed) and placed[last].stretch.run == placed[0].stretch.run:
        if way * (placed[last].rate - placed[last - 1].rate) <= 0:
            break
        last += 1
    if last < _FEWEST + 1:
        return
    start, end = placed[0].start, placed[last - 1].end
    ends = {Fraction(beat) for beat in range(math.floor(start) + 1, math.floor(end) + 1)}
    ends |= {exact for exact in [_loosely(end, loose)] if exact}
    for beat in sorted(ends, reverse=True):
        inside = [each for each in placed[:last] if each.start < beat]
        if len(inside) > _FEWEST:
            yield beat, len(inside), _ramp(inside, start, beat)


def _ramp(placed: Sequence[OnBeats], start: Fraction, end: Fraction) -> RateCurve:
    """Return the ramp from `start` to `end` whose rates go evenly from the second stretch to the last but one."""
    one, other = placed[1], placed[-2]
    middles = [float(each.start + each.end) / 2 for each in (one, other)]
    slope = (other.rate - one.rate) / (middles[1] - middles[0])
    early = max(one.rate - slope * (middles[0] - float(start)), 0.0)
    late = max(other.rate + slope * (float(end) - middles[1]), 0.0)
    share = early / (early + late) if early + late else 0.5
    return RateCurve(2 * min(_RATIOS, key=lambda ratio: abs(ratio - share)))


def _unwarped(
    track: Track,
    runs: Sequence[PathRun],
    origin: float,
    seconds: float,
    beats: Fraction,
    curve: RateCurve,
    most: int,
) -> tuple[TimedMotion, ...] | None:
    """Return the motions that this curve plays in a track, of which these runs begin with the same sample; None if it
    has too few samples, or if there are more than `most`. A beat lasts so many seconds."""
    if len(track) < 4:
        return None
    progress = curve.progress(beats)
    passed = [min(max((sample.time - origin) / seconds, 0.0), float(beats)) for sample in track]
    warped = [sample._replace(time=progress(at) * seconds) for sample, at in zip(track, passed, strict=True)]
    stretches = stretches_of(warped, runs_until(runs, len(track) - 1), most)
    if not stretches:
        return None
    stretches[0] = _prolonged(stretches[0], 0.0, stretches[0].end)
    stretches[-1] = _prolonged(stretches[-1], stretches[-1].start, float(beats) * seconds)
    placed = _placed(stretches, 0.0, 60 / seconds, max(seconds / 50, 1e-3))
    return tuple(TimedMotion(each.end - each.start, each.stretch.amounts) for each in placed)


def _prolonged(stretch: EvenStretch, start: float, end: float) -> EvenStretch:
    """Return the stretch at the same velocity for another stretch of time."""
    factor = (end - start) / stretch.seconds
    return replace(stretch, start=start, end=end, amounts=Amounts(*(each * factor for each in stretch.amounts)))
