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
from improv_core.transcription.track import TimedPlace

_TOKENS = re.compile(r"([MmLlHhVvCcSsQqTtAaZz])|([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)")
_COUNTS = {"m": 2, "l": 2, "h": 1, "v": 1, "c": 6, "s": 4, "q": 4, "t": 2, "a": 7, "z": 0}
_TRANSFORM = re.compile(r"(matrix|translate|scale|rotate)\s*\(([^)]*)\)")
_POINTS = 64
"""The number of points that replace each curve."""
_RATE = 20.0
"""Places per second, as a recording has them."""
_CORNER = math.radians(20)
"""A drawing that bends by more at one point has a corner, where the robot turns on the spot."""
_TURN = 2.0
"""Radians that it turns there in the time that it takes for one unit of the drawing."""
_WIDTH = 4.0
"""The width of a drawing without a scale, in meters."""
_MOST_POINTS = 100_000

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
    if len(points) > _MOST_POINTS:
        raise SourceError(f"{path}, {element.get('id') or tag}: it has over {_MOST_POINTS} points")
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
        need = _COUNTS.get(command.lower(), -1)
        if not command or len(numbers) < need or (need == 0 and not letter) or (need and not number):
            continue
        kind, base = command.lower(), here if command.islower() else 0j
        pairs = (
            [complex(x, y) + base for x, y in zip(numbers[::2], numbers[1::2], strict=False)]
            if kind not in "hvaz"
            else []
        )
        before, here, bend = here, here, None
        if kind == "m":
            start = here = pairs[0]
            points.append(here)
            command = "l" if command == "m" else "L"
        elif kind == "z":
            here = start
            points.append(here)
        elif kind == "l":
            here = pairs[0]
            points.append(here)
        elif kind == "h":
            here = complex(numbers[0] + base.real, here.imag)
            points.append(here)
        elif kind == "v":
            here = complex(here.real, numbers[0] + base.imag)
            points.append(here)
        elif kind == "a":
            end = complex(numbers[5], numbers[6]) + base
            points.extend(_elliptic(before, end, *numbers[:5]))
            here = end
        else:
            mirrored = 2 * before - control
            bends = {"c": pairs, "s": [mirrored, *pairs], "q": pairs, "t": [mirrored, *pairs]}[kind]
            points.extend(_bezier([before, *bends], part / _POINTS) for part in range(1, _POINTS + 1))
            bend, here = bends[-2], bends[-1]
        control = bend if bend is not None else here
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
    if sweep and swept < 0:
        swept += math.tau
    if not sweep and swept > 0:
        swept -= math.tau
    circle = [center + cmath.exp(1j * (begin + swept * part / _POINTS)) for part in range(1, _POINTS + 1)]
    return [complex(p.real * rx, p.imag * ry) * turn for p in circle]


def _driven(points: Sequence[complex], seconds: float) -> list[TimedPlace]:
    """Return the places of a robot that drives along points evenly, and turns on the spot at corners."""
    legs = [(a, b) for a, b in pairwise(points) if abs(b - a) > 1e-9]
    if not legs:
        return [
            TimedPlace(0.0, points[0].real, points[0].imag, 0.0, 0.0),
            TimedPlace(seconds, points[0].real, points[0].imag, 0.0, 0.0),
        ]
    ways = [cmath.phase(b - a) for a, b in legs]
    bends = [math.remainder(after - here, math.tau) for here, after in pairwise(ways)]
    moves: list[tuple[float, complex, complex, float, float]] = []  # how long, from, to, headings
    heading, lead = ways[0], 0.0
    for (a, b), bend in zip(legs, [*bends, 0.0], strict=True):
        corner = abs(bend) > _CORNER
        half = 0.0 if corner else bend / 2  # where a curve continues, a leg's own direction is that of its middle
        moves.append((abs(b - a), a, b, heading - lead, heading + half))
        if corner:
            moves.append((abs(bend) / _TURN, b, b, heading, heading + bend))
        heading, lead = heading + bend, half
    total = math.fsum(move[0] for move in moves)
    places, passed, at = [], 0.0, 0
    count = max(2, round(seconds * _RATE) + 1)
    for number in range(count):
        wanted = total * number / (count - 1)
        while at < len(moves) - 1 and passed + moves[at][0] < wanted:
            passed += moves[at][0]
            at += 1
        length, a, b, before, after = moves[at]
        share = min(max((wanted - passed) / length, 0.0), 1.0) if length else 1.0
        place = a + (b - a) * share
        places.append(
            TimedPlace(seconds * number / (count - 1), place.real, place.imag, 0.0, before + (after - before) * share)
        )
    return places
