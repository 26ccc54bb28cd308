"""Puts a robot's track on the beats, as stretches of one velocity and as gentle movements. Standard library only."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import accumulate, chain, pairwise
from typing import Any, NamedTuple

from improv_core.score.algebra import stand
from improv_core.score.ramps import Stepped, ease, ramp
from improv_core.transcription.amounts import Amounts
from improv_core.transcription.fits import TrackEdge, VelocityFits, cheapest
from improv_core.transcription.polyline import polyline
from improv_core.transcription.stretches import EvenStretch, chained, stretches_of
from improv_core.transcription.tempo import on_grid
from improv_core.transcription.track import Noise, Sample, Track

_GRID = (1, 2, 3, 4)
"""Noisy changes are taken to be on these parts of a beat."""
_PART_COST = {1: 0.0, 2: 2.0, 3: 4.0, 4: 4.0}
"""The cost of an end on such a part of a beat, in natural units of information."""
_FINE_COST = 6.0
"""The cost of an end on a finer part."""
_MAX_TRIED = 24
"""The most movements that are tried as an `ease` of several motions, the simplest first."""
_DENSE = 1.5
"""The fewest stretches in each beat of such an `ease`."""
_BAD = 30.0
"""The cost of a motion, besides that of noise, above which there are several."""
_GENTLE_COST, _RATES_COST = 4.0, 6.0
"""The cost of a gentle movement besides what it is made of, and that of the rates of a `ramp`."""
_MAX_GENTLE = 32
"""The most beats of a gentle movement."""
_FEW = 20
"""Poses that are enough to refute most movements that aren't gentle."""
_SWELL = 0.7
"""In the first part of an `ease`, a robot moves less than this share of its movement in the second part."""
_SWELL_BEATS = 0.25
"""Each of these parts is an eighth of the movement, but at least so many beats, since noisy changes lie on a coarse
grid, and at most a quarter of the movement."""
_RATIOS = sorted({Fraction(part, parts) for parts in (1, 2, 3, 4, 5, 6, 8) for part in range(parts + 1)})
"""The parts of both rates of a `ramp` that its first one may be."""
_FINE = 1e-5
"""Seconds by which the end of a stretch near its track may be moved to a simple part of a beat."""
_NEAR = 3.0
"""The most standard deviations by which poses of such a stretch may be off."""
_WINDOW = 2
"""The number of noisy poses whose mean is compared."""
_JITTER = 1e-3
"""The least noise, in meters, of poses that are compared in means."""
_EXACT = 1e-4
"""Seconds by which a sample may be off and still be at a beat."""


class TimedMotion(NamedTuple):
    """A number of beats with one velocity, in which a robot moves by `amounts`."""

    beats: Fraction
    amounts: Amounts

    @property
    def rate(self) -> float:
        return self.amounts.size / float(self.beats)


class RateCurve(NamedTuple):
    """The rate of a gentle movement: `ease`, or `ramp` with its two rates, which add up to 2."""

    word: str
    rates: tuple[Fraction, ...] = ()

    @lru_cache(maxsize=4096)  # noqa: B019 - curves are few, and small
    def steps(self, beats: Fraction) -> list[tuple[float, float]]:
        """Return the steps of a body of this length: the beats that each lasts, and its rate."""
        made = ramp(stand(beats), *self.rates) if self.rates else ease(stand(beats))
        assert isinstance(made, Stepped)
        return [(float(each.beats), float(each.rate)) for each in made.steps_from(0, False)]


_EASE = RateCurve("ease")


@dataclass(frozen=True, slots=True)
class TimedItem:
    """Motions one after another: a gentle movement if they are played at a rate that changes along a curve."""

    motions: tuple[TimedMotion, ...]
    curve: RateCurve | None = None

    @property
    def beats(self) -> Fraction:
        return sum((each.beats for each in self.motions), Fraction(0))

    @property
    def steps(self) -> list[tuple[float, float]]:
        """The beats that each step of its rate lasts, and the rate."""
        return self.curve.steps(self.beats) if self.curve else [(float(self.beats), 1.0)]


class TrackedRobot(NamedTuple):
    """A robot's track, its fits, and its stretches. `allowed` is how many seconds a change may be off."""

    track: Track
    noise: Noise
    noisy: bool
    allowed: float
    fits: VelocityFits
    stretches: Sequence[EvenStretch]

    @property
    def window(self) -> int:
        """The number of neighboring poses whose mean is compared with a performance."""
        return 1 if self.noise.meters < _JITTER else min(_WINDOW, len(self.track))


def near_items_of(robot: TrackedRobot, tempo: int, nearest: bool) -> Sequence[TimedItem]:
    """Return stretches that end when the track's do, even if its velocity always changes. The `nearest` ones lead from
    pose to pose."""
    meters, radians = (_NEAR * each for each in robot.noise)
    stretches = list(chained(robot.track, meters, radians)) if nearest else robot.stretches
    ends = [on_grid(each.end, tempo, _FINE) for each in stretches]
    spans = zip([Fraction(0), *ends], ends, stretches, strict=False)
    motions = [TimedMotion(b - a, each.amounts.times(float(b - a) * 60 / tempo)) for a, b, each in spans if a < b]
    return [TimedItem((each,)) for each in motions]


def items_of(
    robot: TrackedRobot, tempo: int, stops: Callable[[], bool], roughly: bool = False
) -> tuple[float, Sequence[TimedItem]]:
    """Return what a robot performs, beat 0 being its first sample, and its cost in natural units of information.

    Noisy changes are on simple parts of beats. Gentle movements are found where they cost less than stretches; of
    several motions, only without `roughly`. `stops` ends the search for more of them.
    """
    seconds = 60 / tempo
    nodes = _nodes(robot, tempo)
    cost, placed = _placed(robot.fits, nodes, seconds)
    spans = {} if stops() else _gentle_spans(placed, robot, seconds)
    if not spans:
        return cost, [TimedItem((each,)) for each in placed]
    nodes = sorted({*nodes, *(beat for span in spans for beat in span[:2])})
    edges: list[Iterable[TrackEdge[Any]]] = [*_stretches(robot.fits, nodes, seconds)]
    left = 0 if roughly else _MAX_TRIED
    for start, end, curve in sorted(spans, key=lambda span: span[0].denominator + span[1].denominator):
        if stops():
            break
        price, gentle = _gentle(robot, start, end, curve, seconds, not (left and spans[start, end, curve]))
        left -= bool(left and spans[start, end, curve])
        if gentle:
            begin = bisect_left(nodes, start)
            edges[begin] = chain(edges[begin], [TrackEdge(bisect_left(nodes, end), price, gentle)])
    cost, steps = cheapest(edges)
    return cost, [
        content if isinstance(content, TimedItem) else TimedItem((TimedMotion(nodes[last] - nodes[first], content),))
        for first, last, content in steps
    ]


def _placed(fits: VelocityFits, nodes: Sequence[Fraction], seconds: float) -> tuple[float, list[TimedMotion]]:
    """Return the motions between these beats that describe a track best, and their cost."""
    cost, steps = cheapest(_stretches(fits, nodes, seconds))
    return cost, [TimedMotion(nodes[last] - nodes[first], content) for first, last, content in steps]


def _nodes(robot: TrackedRobot, tempo: int) -> list[Fraction]:
    """Return the beats at which a change may be."""
    origin = robot.track[0].time
    if robot.noisy:
        return _simple_beats((robot.track[-1].time - origin) * tempo / 60)
    ends = (on_grid(each.end, tempo, robot.allowed) for each in robot.stretches)
    return sorted({Fraction(0), *ends})


def _simple_beats(last: float) -> list[Fraction]:
    end = Fraction(math.ceil(last * 4 - 1e-6), 4)
    return sorted({Fraction(place, parts) for parts in _GRID for place in range(math.floor(end * parts) + 1)})


def _stretches(fits: VelocityFits, nodes: Sequence[Fraction], seconds: float) -> list[Iterable[TrackEdge[Amounts]]]:
    costs = [_PART_COST.get(each.denominator, _FINE_COST) for each in nodes]
    return fits.edges([float(each) * seconds for each in nodes], costs)


def _gentle_spans(
    placed: Sequence[TimedMotion], robot: TrackedRobot, seconds: float
) -> dict[tuple[Fraction, Fraction, RateCurve], bool]:
    """Return where there may be gentle movements, judged by the rates of stretches, and if of several motions."""
    found: dict[tuple[Fraction, Fraction, RateCurve], bool] = {}
    rates = [each.rate for each in placed]
    until = polyline((float(each.beats), each.rate) for each in placed)
    ends = list(map(float, accumulate((each.beats for each in placed), initial=Fraction(0))))

    def swells(start: float, part: float) -> bool:
        return abs(until(start + part) - until(start)) < _SWELL * abs(until(start + 2 * part) - until(start + part))

    steps = sorted(after.time - here.time for here, after in pairwise(robot.track))
    loose = 1.01 * steps[len(steps) // 2] / seconds
    begins = [_near(end, after, loose, robot.noisy) for end, after in zip(ends, [*ends[1:], ends[-1]], strict=True)]
    stops = [_near(end, before, loose, robot.noisy) for before, end in zip([0.0, *ends], ends, strict=False)]
    for first in range(len(placed) - 1):
        ramps = _monotone(placed[first:], rates[first:])
        for past in range(first + 2, len(placed) + 1):
            if ends[past] - ends[first] > _MAX_GENTLE:
                break
            eases = rates[first] < rates[first + 1] and rates[past - 1] < rates[past - 2]
            ratio = _ratio(ends, rates, first, past - 1) if past - first <= ramps else None
            for start in begins[first] if eases or ratio is not None else ():
                for end in stops[past]:
                    if start >= end:
                        continue
                    beats = float(end - start)
                    part = min(beats / 4, max(beats / 8, _SWELL_BEATS))
                    if eases and swells(float(start), part) and swells(float(end), -part):
                        found[start, end, _EASE] = past - first >= max(_DENSE * beats, 4)
                    if ratio is not None:
                        found.setdefault((start, end, RateCurve("ramp", (2 * ratio, 2 - 2 * ratio))), False)
    return found


def _near(beat: float, inside: float, loose: float, noisy: bool) -> list[Fraction]:
    """Return the simple beats near a change, or in the stretch beside it: a gentle end is like what is beside it."""
    near = {Fraction(round(beat * parts), parts) for parts in _GRID}
    found = {each for each in near if abs(each - beat) <= (max(loose, 0.5 / each.denominator) if noisy else loose)}
    low, high = sorted((beat, inside))
    halves = {
        Fraction(math.floor(low * 2) + 1, 2),
        Fraction(math.ceil(high * 2) - 1, 2),
        Fraction(math.floor(low) + 1),
        Fraction(math.ceil(high) - 1),
    }
    return sorted(found | {each for each in halves if low < each < high})


def _monotone(placed: Sequence[TimedMotion], rates: Sequence[float]) -> int:
    """Return how many stretches are of one geometry and ever faster, or ever slower."""
    rising = rates[1] > rates[0]
    count = 1
    while (
        count < len(placed)
        and (rates[count] > rates[count - 1]) == rising
        and placed[count].amounts.is_like(placed[count - 1].amounts)
    ):
        count += 1
    return count


def _ratio(ends: Sequence[float], rates: Sequence[float], first: int, last: int) -> Fraction:
    """Return the part of both rates that the first one of a `ramp` is, which these stretches may be."""
    (start, middle), (late, end) = (ends[each : each + 2] for each in (first, last))
    slope = (rates[last] - rates[first]) / (late + end - start - middle) * 2
    early = max(rates[first] - slope * (middle - start) / 2, 0.0)
    later = max(rates[last] + slope * (end - late) / 2, 0.0)
    share = early / (early + later)
    return min(_RATIOS, key=lambda ratio: abs(float(ratio) - share) + 0.004 * ratio.denominator)


def _gentle(
    robot: TrackedRobot, start: Fraction, end: Fraction, curve: RateCurve, seconds: float, roughly: bool
) -> tuple[float, TimedItem | None]:
    """Return the cost of a gentle movement, and its motions; none if it is unlikely."""
    origin = robot.track[0].time
    first = bisect_left(robot.track, origin + float(start) * seconds - _EXACT, key=lambda each: each.time)
    past = bisect_right(robot.track, origin + float(end) * seconds + _EXACT, key=lambda each: each.time)
    track = robot.track[first:past]
    if len(track) < 4:
        return math.inf, None
    beats, begin = end - start, float(start)
    progress = polyline(curve.steps(beats))

    def played(sample: Sample) -> float:
        return progress(max((sample.time - origin) / seconds - begin, 0.0)) * seconds

    nodes = [Fraction(0), beats]
    for samples in (track[:: math.ceil(len(track) / _FEW)], track):
        fits = VelocityFits(samples, robot.noise, [played(each) for each in samples])
        cost, placed = _placed(fits, nodes, seconds)
        is_one = cost <= _BAD + 1.5 * len(samples)
        if not is_one and (roughly or curve.rates or beats.denominator > 2):
            return math.inf, None
    if not is_one:
        if robot.noisy:
            nodes = _simple_beats(float(beats))
        else:
            ends = (on_grid(each.end, 60 / seconds, robot.allowed) for each in stretches_of(fits))
            nodes = sorted({Fraction(0), *(each for each in ends if each < beats), beats})
        cost, placed = _placed(fits, nodes, seconds)
    gentle = TimedItem(tuple(placed), curve)
    if gentle.beats != beats:
        return math.inf, None
    cost += _GENTLE_COST + (_RATES_COST if curve.rates else 0.0)
    return cost, gentle
