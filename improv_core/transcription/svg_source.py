"""Reads drawings: each path of an SVG is the way of one robot (defusedxml and svg.path, imported lazily)."""

from __future__ import annotations

import cmath
import math
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from improv_core.transcription.sources import LARGEST, Recording, SourceError, robot_name
from improv_core.transcription.track import Sample, TimedPlace, interpolated

_TRANSFORM = re.compile(r"(\w+)\s*\(([^)]*)\)")
_CURVE_POINTS = 64
"""The number of points that replace each curve."""
_BESIDE = 1e-4
"""The share of a curve from a point to others that show its direction there."""
_NEAR = 1e-3
"""Meters: points that are nearer to each other have no direction."""
_CORNER = math.radians(20)
"""A drawing that bends by more at one point has a corner, where the robot turns on the spot."""
_TURN = 2.0
"""The radians that it turns there in the time in which it drives a meter."""
_WIDTH = 4.0
"""The width of a drawing without a scale, in meters."""
_MAX_POINTS = 100_000
_UNREAD = ("text", "image", "use")
"""Elements that people see, but that are neither paths nor shapes."""

Matrix = tuple[complex, complex, complex]
"""A map of the plane: z → a z + b conj(z) + c."""
_SAME: Matrix = (1 + 0j, 0j, 0j)
_Node = tuple[complex, complex]
"""A point of a shape, and the direction in which it goes on there."""


def read_svg(path: Path, seconds: float, scale: float | None) -> Recording:
    """Read an SVG's paths and shapes, drawn in this many seconds. `scale` is in meters per unit.

    Raises SourceError.
    """
    from defusedxml.common import DefusedXmlException
    from defusedxml.ElementTree import parse

    try:
        root: Any = parse(path).getroot()
    except (SyntaxError, DefusedXmlException) as error:
        raise SourceError(f"{path}: it is no SVG: {error}") from None
    drawn = [(name, nodes) for name, nodes in _shapes(path, root, _SAME) if len(nodes) > 1]
    unread = ", ".join(tag for tag in _UNREAD if root.find(f".//{{*}}{tag}") is not None)
    if not drawn:
        raise SourceError(f"{path}: it has no paths or shapes{f', only {unread}' if unread else ''}: draw some")
    guesses = [f"left out: {unread}; convert what you need to paths"] if unread else []
    if scale is None:
        axes = zip(*((point.real, point.imag) for _, nodes in drawn for point, _ in nodes), strict=True)
        wide = max(max(axis) - min(axis) for axis in axes)
        scale = _WIDTH / wide if wide else 1.0
        guesses.append(f"the drawing is {_WIDTH:g} m wide: {scale:.4g} m per unit")
    places: dict[str, Sequence[TimedPlace]] = {}
    for name, nodes in drawn:
        # On screens, y points down.
        way = _driven([(point.conjugate() * scale, way.conjugate()) for point, way in nodes], seconds)
        places[robot_name(name, list(places))] = [TimedPlace(*each) for each in way]
    return Recording(places, guesses, places)


def _shapes(path: Path, element: Any, outer: Matrix) -> Iterator[tuple[str, list[_Node]]]:
    """Yield the names and the nodes of the shapes in an element."""
    tag = str(element.tag).rpartition("}")[2]
    place = f"{path}, {element.get('id') or tag}"
    if tag in ("defs", "clipPath", "symbol", "marker"):
        return
    try:
        a, b, c = matrix = _then(outer, _matrix(element.get("transform", "")))
        nodes = [
            (a * p + b * p.conjugate() + c, a * way + b * way.conjugate()) for p, way in _nodes(_data(tag, element))
        ]
    except (ArithmeticError, AssertionError, LookupError, TypeError, ValueError):
        raise SourceError(f"{place}: its path or transform is not understood") from None
    if len(nodes) > _MAX_POINTS:
        raise SourceError(f"{place}: it has over {_MAX_POINTS} points")
    if not all(abs(point) <= LARGEST for point, _ in nodes):
        raise SourceError(f"{place}: a number is too large")
    if nodes:
        yield element.get("id") or path.stem, nodes
    for child in element:
        yield from _shapes(path, child, matrix)


def _data(tag: str, element: Any) -> str:
    """Return the shape of an element as the data of a path; an empty text if it has none."""

    def number(*names: str) -> float:
        value = next((float(value) for each in names if (value := element.get(each))), 0.0)
        if not abs(value) <= LARGEST:
            raise ValueError(value)
        return value

    match tag:
        case "path":
            return str(element.get("d", ""))
        case "polyline" | "polygon" if points := element.get("points", "").strip():
            return f"M{points}{'z' if tag == 'polygon' else ''}"
        case "line":
            return "M" + " ".join(element.get(each, "0") for each in ("x1", "y1", "x2", "y2"))
        case "circle" | "ellipse":
            a, b = number("r", "rx"), number("r", "ry")
            return f"M{number('cx') + a} {number('cy')}a{a} {b} 0 0 1 {-2 * a} 0a{a} {b} 0 0 1 {2 * a} 0z"
        case "rect" if "%" not in element.get("width", ""):  # in %, it is a background
            x, y, wide, high = map(number, ("x", "y", "width", "height"))
            a, b = min(number("rx", "ry"), wide / 2), min(number("ry", "rx"), high / 2)
            arc, across, down = f"a{a} {b} 0 0 1", wide - 2 * a, high - 2 * b
            there, back = (
                f"h{across}{arc} {a} {b}v{down}{arc} {-a} {b}",
                f"h{-across}{arc} {-a} {-b}v{-down}{arc} {a} {-b}",
            )
            return f"M{x + a} {y}{there}{back}z"
    return ""


def _nodes(data: str) -> Iterator[_Node]:
    """Yield the points of a path's data, and the directions there; of several parts, all, joined."""
    from svg.path import Line, Move, NonLinear, parse_path

    last = None
    for segment in parse_path(data):
        if isinstance(segment, Move):
            segment = Line(segment.end if last is None else last, segment.end)
        last = segment.end
        parts = _CURVE_POINTS if isinstance(segment, NonLinear) else 1
        for share in (part / parts for part in range(parts + 1)):
            # The derivative would be 0 where a control point is at an end.
            way = segment.point(min(share + _BESIDE, 1.0)) - segment.point(max(share - _BESIDE, 0.0))
            if way:
                yield segment.point(share), way


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


def _driven(nodes: Sequence[_Node], seconds: float) -> list[Sample]:
    """Return the poses of a robot that drives along nodes evenly, and turns on the spot at corners."""
    waypoints: list[Sample] = []
    for point, way in nodes:
        here = Sample(0.0, point.real, point.imag, 0.0, cmath.phase(way))
        if not waypoints:
            waypoints.append(here)
            continue
        last = waypoints[-1]
        far, turn = last.pose.apart(here.pose)[0], math.remainder(here.heading - last.heading, math.tau)
        if far >= _NEAR:
            waypoints.append(here._replace(time=last.time + far, heading=last.heading + turn))
        elif abs(turn) > _CORNER:
            waypoints.append(last._replace(time=last.time + abs(turn) / _TURN, heading=last.heading + turn))
        else:
            waypoints[-1] = last._replace(heading=last.heading + turn / 2)
    if len(waypoints) == 1:
        waypoints.append(waypoints[0]._replace(time=1.0))  # it waits at a dot
    share = seconds / waypoints[-1].time
    return interpolated([each._replace(time=each.time * share) for each in waypoints])
