"""Reads drawings: each path of an SVG is the way of one robot (defusedxml and svg.path, imported lazily)."""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from improv_core.transcription.sources import LARGEST, Recording, SourceError, robot_name
from improv_core.transcription.track import TimedPlace, driven

_TRANSFORM = re.compile(r"(\w+)\s*\(([^)]*)\)")
_CURVE_POINTS = 64
"""The number of points that replace each curve."""
_NEAR = 1e-3
"""Meters: points that are nearer to each other have no direction."""
_CORNER = math.radians(20)
"""A drawing that bends by more at one point has a corner, where the robot turns on the spot."""
_TURN = 2.0
"""The radians that it turns there in the time in which it drives a meter."""
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
        axes = zip(*((point.real, point.imag) for _, points in drawn for point in points), strict=True)
        wide = max(max(axis) - min(axis) for axis in axes)
        scale = _WIDTH / wide if wide else 1.0
        guesses.append(f"the drawing is {_WIDTH:g} m wide: {scale:.4g} m per unit")
    places: dict[str, Sequence[TimedPlace]] = {}
    for name, points in drawn:
        # On screens, y points down.
        places[robot_name(name, list(places))] = _driven([p.conjugate() * scale for p in points], seconds)
    return Recording(places, guesses)


def _shapes(path: Path, element: Any, outer: Matrix) -> Iterator[tuple[str, list[complex]]]:
    """Yield the names and the points of the shapes in an element."""
    tag = str(element.tag).rpartition("}")[2]
    place = f"{path}, {element.get('id') or tag}"
    if tag in ("defs", "clipPath", "symbol", "marker"):
        return
    try:
        a, b, c = matrix = _then(outer, _matrix(element.get("transform", "")))
        points = [a * p + b * p.conjugate() + c for p in _points(_data(tag, element))]
    except (ArithmeticError, AssertionError, LookupError, TypeError, ValueError):
        raise SourceError(f"{place}: its path or transform is not understood") from None
    if len(points) > _MAX_POINTS:
        raise SourceError(f"{place}: it has over {_MAX_POINTS} points")
    if not all(abs(point) <= LARGEST for point in points):
        raise SourceError(f"{place}: a number is too large")
    if points:
        yield element.get("id") or path.stem, points
    for child in element:
        yield from _shapes(path, child, matrix)


def _data(tag: str, element: Any) -> str:
    """Return the shape of an element as the data of a path; an empty text if it has none."""
    if tag == "path":
        return str(element.get("d", ""))
    if tag in ("polyline", "polygon") and (points := element.get("points", "").strip()):
        return f"M{points}{'z' if tag == 'polygon' else ''}"
    if tag == "line":
        x1, y1, x2, y2 = (element.get(each, "0") for each in ("x1", "y1", "x2", "y2"))
        return f"M{x1} {y1} {x2} {y2}"
    return ""


def _points(data: str) -> Iterator[complex]:
    """Yield the points of a path's data; of several parts, all, joined."""
    from svg.path import NonLinear, parse_path

    for segment in parse_path(data):
        parts = _CURVE_POINTS if isinstance(segment, NonLinear) else 1
        yield from (segment.point(part / parts) for part in range(1, parts + 1))


def _matrix(text: str) -> Matrix:
    made = _SAME
    for kind, inside in _TRANSFORM.findall(text):
        match kind, [float(each) for each in re.findall(r"[-+.\deE]+", inside)]:
            case "translate", [x, *y]:
                one: Matrix = (1 + 0j, 0j, complex(x, *y))
            case "scale", [x, *y]:
                z = complex(x, *(y or [x]))
                one = (complex(z.real + z.imag) / 2, complex(z.real - z.imag) / 2, 0j)
            case "rotate", [degrees, *center]:
                turn, fixed = cmath.rect(1.0, math.radians(degrees)), complex(*center)
                one = (turn, 0j, fixed - turn * fixed)
            case "matrix", [a, b, c, d, e, f]:
                one = (complex(a + d, b - c) / 2, complex(a - d, b + c) / 2, complex(e, f))
            case _:
                raise ValueError(kind)
        made = _then(made, one)
    return made


def _then(outer: Matrix, inner: Matrix) -> Matrix:
    (a, b, c), (d, e, f) = outer, inner
    return a * d + b * e.conjugate(), a * e + b * d.conjugate(), a * f + b * f.conjugate() + c


def _driven(points: Sequence[complex], seconds: float) -> list[TimedPlace]:
    """Return the places of a robot that drives along points evenly, and turns on the spot at corners."""
    kept = [points[0]]
    for point in points:
        if abs(point - kept[-1]) > _NEAR:
            kept.append(point)
    legs = [b - a for a, b in pairwise(kept)]
    bends = [abs(cmath.phase(after / here)) for here, after in pairwise([*legs, *legs[-1:]])]
    waypoints, passed = [(0.0, kept[0])], 0.0
    for point, leg, bend in zip(kept[1:], legs, bends, strict=True):
        passed += abs(leg)
        waypoints.append((passed, point))
        if bend > _CORNER:
            passed += bend / _TURN
            waypoints.append((passed, point))
    waypoints += [] if legs else [(1.0, kept[0])]  # it waits at a dot
    share = seconds / waypoints[-1][0]
    return [TimedPlace(*each) for each in driven([TimedPlace(at * share, p.real, p.imag) for at, p in waypoints])]
