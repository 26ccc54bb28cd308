"""Reads drawings: each path of an SVG is the way of one robot (defusedxml, imported lazily)."""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from improv_core.transcription.sources import Recording, SourceError, robot_name
from improv_core.transcription.track import TimedPlace, driven

_TOKENS = re.compile(r"([MmLlHhVvCcSsQqTtAaZz])|([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)")
_COUNTS = {"m": 2, "l": 2, "h": 1, "v": 1, "c": 6, "s": 4, "q": 4, "t": 2, "a": 7, "z": 0}
_TRANSFORM = re.compile(r"(matrix|translate|scale|rotate)\s*\(([^)]*)\)")
_POINTS = 64
"""The number of points that replace each curve."""
_NEAR = 1e-3
"""Meters: points that are nearer to each other have no direction."""
_CORNER = math.radians(20)
"""A drawing that bends by more at one point has a corner, where the robot turns on the spot."""
_TURN = 2.0
"""The radians that it turns there in the time in which it drives one unit of the drawing."""
_WIDTH = 4.0
"""The width of a drawing without a scale, in meters."""
_MAX_POINTS = 100_000

Matrix = tuple[complex, complex, complex]
"""A map of the plane: z → a z + b conj(z) + c."""
_SAME: Matrix = (1 + 0j, 0j, 0j)


def read_svg(path: Path, seconds: float, scale: float | None) -> Recording:
    """Read an SVG's paths, lines, and polygons, drawn in this many seconds. `scale` is in meters per unit.

    Raises SourceError.
    """
    from defusedxml.common import DefusedXmlException
    from defusedxml.ElementTree import parse

    try:
        root = parse(path).getroot()
    except (SyntaxError, DefusedXmlException) as error:
        raise SourceError(f"{path}: it is no SVG: {error}") from None
    drawn = [(name, points) for name, points in _shapes(path, root, _SAME) if len(points) > 1]
    if not drawn:
        raise SourceError(f"{path}: it has no path, line, polyline, or polygon")
    guesses = []
    if scale is None:
        every = [point for _, points in drawn for point in points]
        wide = max(
            max(p.real for p in every) - min(p.real for p in every),
            max(p.imag for p in every) - min(p.imag for p in every),
        )
        scale = _WIDTH / wide if wide else 1.0
        guesses.append(f"the drawing is {_WIDTH:g} m wide: {scale:.4g} m per unit")
    places: dict[str, Sequence[TimedPlace]] = {}
    for name, points in drawn:
        # On screens, y points down.
        places[robot_name(name, list(places))] = _driven([p.conjugate() * scale for p in points], seconds)
    return Recording(places, guesses)


def _shapes(path: Path, element: Any, outer: Matrix) -> Iterator[tuple[str, list[complex]]]:
    matrix = _then(outer, _matrix(element.get("transform", "")))
    tag = str(element.tag).rpartition("}")[2]
    if tag in ("defs", "clipPath", "symbol", "marker"):
        return
    points: list[complex] = []
    try:
        if tag == "path":
            points = _path(element.get("d", ""))
        elif tag in ("polyline", "polygon"):
            numbers = [float(each) for each in re.findall(r"[-+.\deE]+", element.get("points", ""))]
            points = [complex(x, y) for x, y in zip(numbers[::2], numbers[1::2], strict=False)]
            points += points[:1] if tag == "polygon" else []
        elif tag == "line":
            points = [complex(*(float(element.get(f"{axis}{end}", 0)) for axis in "xy")) for end in "12"]
    except ValueError as error:
        raise SourceError(f"{path}, {element.get('id') or tag}: {error}") from None
    if len(points) > _MAX_POINTS:
        raise SourceError(f"{path}, {element.get('id') or tag}: it has over {_MAX_POINTS} points")
    a, b, c = matrix
    if points:
        yield element.get("id") or path.stem, [a * p + b * p.conjugate() + c for p in points]
    for child in element:
        yield from _shapes(path, child, matrix)


def _matrix(text: str) -> Matrix:
    made = _SAME
    for kind, inside in _TRANSFORM.findall(text):
        n = [float(each) for each in re.findall(r"[-+.\deE]+", inside)]
        if kind == "translate" and n:
            one: Matrix = (1 + 0j, 0j, complex(n[0], n[1] if len(n) > 1 else 0))
        elif kind == "scale" and n:
            sx, sy = n[0], n[1] if len(n) > 1 else n[0]
            one = (complex((sx + sy) / 2), complex((sx - sy) / 2), 0j)
        elif kind == "rotate" and n:
            turn, center = cmath.exp(1j * math.radians(n[0])), complex(*n[1:3]) if len(n) > 2 else 0j
            one = (turn, 0j, center - turn * center)
        elif kind == "matrix" and len(n) == 6:
            a, b, c, d, e, f = n
            one = (complex(a + d, b - c) / 2, complex(a - d, b + c) / 2, complex(e, f))
        else:
            continue
        made = _then(made, one)
    return made


def _then(outer: Matrix, inner: Matrix) -> Matrix:
    (a, b, c), (d, e, f) = outer, inner
    return a * d + b * e.conjugate(), a * e + b * d.conjugate(), a * f + b * f.conjugate() + c


def _path(text: str) -> list[complex]:
    """Return the points of a path's data; of several parts, all, joined. Raises ValueError."""
    points: list[complex] = []
    command, numbers = "", []
    here = start = control = 0j
    for letter, number in _TOKENS.findall(text):
        if number:
            numbers.append(float(number))
        if letter:
            command, numbers = letter, []
        kind = command.lower()
        need = _COUNTS.get(kind, -1)
        if not command or len(numbers) < need or (need == 0 and not letter) or (need and not number):
            continue
        base = here if command.islower() else 0j
        if kind in "hv":
            numbers = [numbers[0], here.imag - base.imag] if kind == "h" else [here.real - base.real, numbers[0]]
        first = len(numbers) % 2  # of an arc's, the last two are its end
        bends = [complex(x, y) + base for x, y in zip(numbers[first::2], numbers[first + 1 :: 2], strict=True)]
        if kind == "a":
            points += _elliptic(here, bends[-1], *numbers[:5])
            bends = bends[-1:]
        else:  # a line is a curve that bends nowhere
            bends = [start] if kind == "z" else [2 * here - control, *bends] if kind in "st" else bends
            parts = _POINTS if len(bends) > 1 else 1
            points += (_bezier([here, *bends], part / parts) for part in range(1, parts + 1))
        here, control = bends[-1], bends[-2:][0]
        if kind == "m":
            start, command = here, "l" if command == "m" else "L"
        numbers = []
    if command == "" and text.strip():
        raise ValueError("its path is not understood")
    return points


def _bezier(points: Sequence[complex], share: float) -> complex:
    while len(points) > 1:
        points = [a + (b - a) * share for a, b in pairwise(points)]
    return points[0]


def _elliptic(
    one: complex, other: complex, rx: float, ry: float, tilt: float, large: float, sweep: float
) -> list[complex]:
    """Return points of an elliptical arc (SVG 1.1, appendix F.6)."""
    rx, ry = abs(rx), abs(ry)
    if not rx or not ry or one == other:
        return [other]
    turn = cmath.exp(1j * math.radians(tilt))

    def flat(p: complex) -> complex:
        p = p / turn
        return complex(p.real / rx, p.imag / ry)

    a, b = flat(one), flat(other)
    half = abs(b - a) / 2
    if half > 1:
        rx, ry, half = rx * half, ry * half, 1.0
        a, b = flat(one), flat(other)
    away = 1j * (b - a) / abs(b - a) * math.sqrt(max(1 - half * half, 0.0))
    center = (a + b) / 2 + (away if bool(large) != bool(sweep) else -away)
    begin, swept = cmath.phase(a - center), cmath.phase((b - center) / (a - center))
    swept = swept % math.tau if sweep else -(-swept % math.tau)
    circle = [center + cmath.exp(1j * (begin + swept * part / _POINTS)) for part in range(1, _POINTS + 1)]
    return [complex(p.real * rx, p.imag * ry) * turn for p in circle]


def _driven(points: Sequence[complex], seconds: float) -> list[TimedPlace]:
    """Return the places of a robot that drives along points evenly, and turns on the spot at corners."""
    kept = [points[0]]
    for point in points:
        if abs(point - kept[-1]) > _NEAR:
            kept.append(point)
    legs = [b - a for a, b in pairwise(kept)]
    bends = [abs(cmath.phase(after / here)) for here, after in pairwise(legs)]
    waypoints, passed = [(0.0, kept[0])], 0.0
    for point, leg, bend in zip(kept[1:], legs, [*bends, 0.0], strict=True):
        passed += abs(leg)
        waypoints.append((passed, point))
        if bend > _CORNER:
            passed += bend / _TURN
            waypoints.append((passed, point))
    waypoints += [] if legs else [(1.0, kept[0])]
    share = seconds / waypoints[-1][0]
    return [TimedPlace(*each) for each in driven([TimedPlace(at * share, p.real, p.imag) for at, p in waypoints])]
