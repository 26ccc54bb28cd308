"""The words for what a person draws on the floor or performs with keys. Standard library only."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

from improv_core.score.motion import Pose, Twist
from improv_core.score.profiles import Profile
from improv_core.transcription.amounts import Amounts
from improv_core.transcription.folding import bracketed, folded
from improv_core.transcription.wording import Move, Rounding, amounts_of, moves_for, place_near, series_text

MIN_LENGTH = 0.05
"""Meters: a hand that moved less has drawn nothing."""
_TREMOR = 0.015
"""The inaccuracy of a hand, as a share of the drawing's size."""
_MIN_TREMOR = 0.01
"""The least inaccuracy, in meters."""
_MAX_POINTS = 100
"""More points of a stroke say nothing more, and each pair of them is a curve to try."""
_PATIENCE = 6
"""Once no curve from a point fits this many ends in a row, farther ends are not tried."""
_ARC_COST = 1.2
"""The cost of an arc, which takes more words than a line, whose cost is 1."""
_SLIGHT = math.radians(45)
"""An arc that turns by less costs more: up to 2 if it hardly turns."""
_CORNER_COST = 1.0
"""A corner takes a turn on the spot, and so as many words as a line."""
_MISFIT_COST = 0.3
_FAR = 8
"""A gap between two points that is this many times the usual one was not drawn: it is a line."""
_FEWEST = 4
"""Fewer places make no arc."""
_END_MISFIT = 2.5
"""The ends of a curve may be this many times as far from it as its other places: more is a corner in an arc."""
_INFINITY = 1e6
"""Meters from a line to the center of the circle that it is taken to be."""
_FLAT = 4e-12
"""Places whose spreads along and across differ by more are on a line."""
_KINK = math.radians(20)
"""A robot doesn't turn on the spot for less: the next arc makes it up."""
_ALIKE = 0.3
"""The share by which the curvatures of two arcs of one circle may differ."""
_ROUNDING = 0.07
"""The share of a length that people round."""
_TURN_ROUNDING = math.radians(7.5)
_KEYS_ROUNDING = Rounding(1e-3, 1e-3)


class DrawnPoint(NamedTuple):
    """A point on the floor, in meters, and the beat at which the hand was there."""

    beat: float
    x: float
    y: float


class PressedKeys(NamedTuple):
    """The keys that a person holds from a beat on: `ahead` and `turn` are -1, 0, or 1."""

    beat: float
    ahead: int
    turn: int


class _Curve(NamedTuple):
    """A line or an arc from a point to another: its first direction, its length in meters, and its turn in radians."""

    start: complex
    end: complex
    direction: float
    length: float
    turn: float
    beats: float


def words_drawn(stroke: Sequence[DrawnPoint], heading: float | None, profile: Profile, parts: int) -> tuple[Pose, str]:
    """Return the pose at which a stroke begins, and the words that draw it. Strokes below `MIN_LENGTH` have none.

    The robot first turns to it from its `heading` (radians), or begins that way if it has none, at a place that is
    rounded like a length: the whole stroke moves along. Each line or arc takes the time in which it was drawn, to an
    nth of a beat (`parts`), or with 0 parts, one beat. Until it begins, the robot rests.
    """
    if heading is None:
        stroke = _from_round_place(stroke)
    curves = _curves(stroke)
    if not curves:
        return Pose(), ""
    if heading is None:
        heading = math.radians(round(math.degrees(math.remainder(curves[0].direction, math.tau)) / 15) * 15)
    start = Pose(stroke[0].x, stroke[0].y, 0.0, heading)
    rest = Fraction(round(stroke[0].beat * parts), parts) if parts else Fraction(0)
    before = moves_for(rest, Amounts(), profile, _KEYS_ROUNDING) if rest else []
    return start, _text([*before, *_moves(curves, start, profile, parts)])


def words_performed(keys: Sequence[PressedKeys], end: float, speeds: Twist, profile: Profile, parts: int) -> str:
    """Return the words for keys that were held until the beat `end`, each change put on the nearest nth of a beat. Keys
    that were only tapped count as held for one.

    A held key moves a robot by `speeds`, in meters and radians per beat.
    """
    changes = [PressedKeys(0.0, 0, 0), *keys, PressedKeys(end, 0, 0)]
    moves: list[Move] = []
    begun = pressed = Fraction(0)
    for here, after in pairwise(changes):
        stop = Fraction(round(after.beat * parts), parts)
        if not (here.ahead or here.turn):
            pressed = stop
        elif stop == pressed and not (after.ahead or after.turn):
            stop += Fraction(1, parts)
        if stop > begun:
            beats = float(stop - begun)
            amounts = Amounts(x=here.ahead * speeds.x * beats, yaw=here.turn * speeds.yaw * beats)
            moves += moves_for(stop - begun, amounts, profile, _KEYS_ROUNDING)
            begun = stop
    while moves and moves[-1].voices[0].word == "rest":
        moves.pop()
    return _text(moves)


def _from_round_place(stroke: Sequence[DrawnPoint]) -> list[DrawnPoint]:
    """Return a stroke that is moved a little, so that it begins at a place as round as its lengths."""
    near = _rounding(max((math.dist(each[1:], stroke[0][1:]) for each in stroke), default=0.0)).meters
    x, y = (place_near(each, near) - each for each in stroke[0][1:]) if stroke else (0.0, 0.0)
    return [DrawnPoint(each.beat, each.x + x, each.y + y) for each in stroke]


def _text(moves: Sequence[Move]) -> str:
    return series_text(folded(bracketed(moves))) if moves else ""


def _moves(curves: Sequence[_Curve], start: Pose, profile: Profile, parts: int) -> Iterator[Move]:
    """Yield the moves along curves. Each aims at the drawn point from where the rounded ones before have led, so that
    roundings don't add up."""
    pose = start
    late = Fraction(0)  # beats that turns on the spot have taken from the curves after them
    for curve in curves:
        length, turn, direction = curve.length, curve.turn, curve.direction
        if abs(turn) < math.pi:
            way = curve.end - complex(pose.x, pose.y)
            direction = cmath.phase(way) - turn / 2
            length *= abs(way) / (abs(curve.end - curve.start) or abs(way))
        off = math.remainder(direction - pose.heading, math.tau)
        least = beats = Fraction(1, parts or 1)
        steps = [(least, Amounts(yaw=off))] if abs(off) > _KINK else []
        if turn and not steps:
            turn += off
        if parts:
            drawn = Fraction(round(curve.beats * parts), parts) - late - least * len(steps)
            beats = max(drawn, least)
            late = beats - drawn
        for lasts, amounts in (*steps, (beats, Amounts(x=length, yaw=turn))):
            for move in moves_for(lasts, amounts, profile, _rounding(amounts.x)):
                pose = pose.then(amounts_of(move, profile).pose())
                yield move


def _rounding(length: float) -> Rounding:
    return Rounding(max(_ROUNDING * length, MIN_LENGTH / 2), _TURN_ROUNDING)


def _curves(stroke: Sequence[DrawnPoint]) -> list[_Curve]:
    """Return the fewest lines and arcs that a hand may have meant; none if it hardly moved."""
    places = [complex(each.x, each.y) for each in stroke]
    size = max((abs(place - places[0]) for place in places), default=0.0)
    if size < MIN_LENGTH:
        return []
    tremor = max(size * _TREMOR, _MIN_TREMOR)
    length = sum(abs(after - here) for here, after in pairwise(places))
    kept = _spaced(stroke, max(tremor / 2, length / _MAX_POINTS))
    places = _calmed([complex(each.x, each.y) for each in kept])
    costs = [0.0, *[math.inf] * (len(places) - 1)]
    best: dict[int, tuple[int, _Curve]] = {}
    for first in range(len(places) - 1):
        misses = 0
        for last in range(first + 1, len(places)):
            fit = _fit(places[first : last + 1], kept[last].beat - kept[first].beat, tremor)
            misses = 0 if fit else misses + 1
            bends = first and fit and abs(_kink(best[first][1], fit[1])) > _KINK
            if fit and (cost := costs[first] + fit[0] + _CORNER_COST * bool(bends)) < costs[last]:
                costs[last], best[last] = cost, (first, fit[1])
            if misses == _PATIENCE:
                break
    found: list[_Curve] = []
    last = len(places) - 1
    while last:
        last, curve = best[last]
        found.append(curve)
    return _meeting(_joined(found[::-1]), 4 * tremor)


def _spaced(stroke: Sequence[DrawnPoint], least: float) -> list[DrawnPoint]:
    """Return the points of a stroke that are so far apart, and its last one, with others where a line is far longer."""
    kept = [stroke[0]]
    for each in stroke:
        last, far = kept[-1], math.dist(each[1:], kept[-1][1:])
        steps = int(far / least) if far > _FAR * least else int(far >= least)
        shares = (step / steps for step in range(1, steps + 1))
        kept += [DrawnPoint(*(a + share * (b - a) for a, b in zip(last, each, strict=True))) for share in shares]
    return [*kept[:-1], stroke[-1]] if len(kept) > 2 else [stroke[0], stroke[-1]]


def _calmed(places: Sequence[complex]) -> list[complex]:
    """Return places between their neighbors; the first and the last one stay."""
    three = zip(places, places[1:], places[2:], strict=False)
    return [places[0], *((before + 2 * here + after) / 4 for before, here, after in three), places[-1]]


def _fit(places: Sequence[complex], beats: float, tremor: float) -> tuple[float, _Curve] | None:
    """Return the line or the arc that a hand may have meant, and what it costs; None if it was neither.

    Near a corner, a hand is on neither side of it: the two outermost places don't count. A line goes through their mean
    in the direction in which they spread. The center of an arc is the algebraic fit of I. Kåsa, *A circle fitting
    procedure and its error analysis*, IEEE Transactions on Instrumentation and Measurement 25(1), 1976.
    """
    inner = places[1:-1] if len(places) > _FEWEST + 2 else places
    mean = sum(inner) / len(inner)
    off = [place - mean for place in inner]
    spread, square = math.fsum(abs(each) ** 2 for each in off), sum(each * each for each in off)
    if line := _around(mean + _INFINITY * 1j * cmath.exp(0.5j * cmath.phase(square)), places, inner, beats, tremor):
        return line
    area = spread**2 - abs(square) ** 2
    if len(inner) < _FEWEST or area <= _FLAT * spread**2:
        return None
    skew = sum(abs(each) ** 2 * each for each in off)
    return _around(mean + (spread * skew - square * skew.conjugate()) / area, places, inner, beats, tremor)


def _around(
    center: complex, places: Sequence[complex], inner: Sequence[complex], beats: float, tremor: float
) -> tuple[float, _Curve] | None:
    """Return the arc around a center that is near the inner ones of places, and what it costs; None if they are too far
    from it, or if they turn back. An arc whose center is far away is a line."""
    distances = [abs(place - center) for place in inner]
    radius = math.fsum(distances) / len(inner)
    off = [each - radius for each in distances]
    if radius < tremor or max(map(abs, off)) > tremor:
        return None
    spokes = [place - center for place in places]
    if max(abs(abs(spoke) - radius) for spoke in (spokes[0], spokes[-1])) > _END_MISFIT * tremor:
        return None
    turns = [cmath.phase(after / here) for here, after in pairwise(spokes)]
    turn = math.fsum(turns)
    if any(each * turn < 0 and abs(each) * radius > tremor for each in turns):
        return None
    direction = cmath.phase(spokes[0]) + math.copysign(math.pi / 2, turn)
    start, end = (center + radius * spoke / (abs(spoke) or 1.0) for spoke in (spokes[0], spokes[-1]))
    misfit = _MISFIT_COST * math.fsum(each * each for each in off) / len(off) / tremor**2
    is_line = radius > _INFINITY / 2
    curve = _Curve(start, end, direction, radius * abs(turn), 0.0 if is_line else turn, beats)
    return misfit + (1 if is_line else _ARC_COST + max(2 - 2 * abs(turn) / _SLIGHT, 0.0)), curve


def _joined(curves: Sequence[_Curve]) -> list[_Curve]:
    """Return the curves, with successive arcs of one circle joined."""
    found: list[_Curve] = []
    for curve in curves:
        if found and _are_one(found[-1], curve):
            last = found.pop()
            turn, beats = last.turn + curve.turn, last.beats + curve.beats
            curve = _Curve(last.start, curve.end, last.direction, last.length + curve.length, turn, beats)
        found.append(curve)
    return found


def _meeting(curves: Sequence[_Curve], reach: float) -> list[_Curve]:
    """Return curves with lines that end where they cross the next one: a hand cuts corners."""
    found = list(curves)
    for index, (one, other) in enumerate(pairwise(curves)):
        if one.turn or other.turn:
            continue
        along, across = (cmath.exp(1j * each.direction) for each in (one, other))
        area = (along.conjugate() * across).imag
        if not area:
            continue
        corner = one.end + along * ((other.start - one.end).conjugate() * across).imag / area
        if abs(corner - one.end) < reach and abs(corner - other.start) < reach:
            found[index] = _to(found[index], found[index].start, corner)
            found[index + 1] = _to(other, corner, other.end)
    return found


def _to(line: _Curve, start: complex, end: complex) -> _Curve:
    return line._replace(start=start, end=end, length=abs(end - start))


def _are_one(one: _Curve, other: _Curve) -> bool:
    bends = [curve.turn / curve.length for curve in (one, other)]
    kink = abs(_kink(one, other))
    return kink < (_KINK if all(bends) else _KINK / 2) and abs(bends[0] - bends[1]) <= _ALIKE * max(map(abs, bends))


def _kink(one: _Curve, other: _Curve) -> float:
    """Return the turn on the spot between two curves, in radians."""
    return math.remainder(other.direction - one.direction - one.turn, math.tau)
