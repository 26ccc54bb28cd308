"""Write what people change on the page into their program: the starts of robots, with `at`, and the tempo."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise, takewhile

from improv_core.diagnostics import Edit
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.program import Placed
from improv_core.robots.edits import Start
from improv_core.robots.formation import radius_of
from improv_core.score.motion import Pose, wrapped
from improv_core.syntax.nodes import AtPoint, InFormation, Number
from improv_core.syntax.vocabulary import UNITS
from improv_core.text import Span

UNPLACED = "a line with `at` has an error: fix it first"
"""The message if nothing could be written."""
_OPENING = ("AT", "IS", "ROOM", "BAR_LENGTH", "BEAT")
"""The signs of the lines below which places are written, if nothing else is above them."""
_SAME = 1e-6
"""Differences in meters or radians that don't take a robot out of a formation."""


def placed(analysis: Analysis, starts: Mapping[str, Start]) -> tuple[Edit, ...] | None:
    """Return the edits that give these robots these starts, rounded to thousandths; all others keep theirs.

    A robot that leaves a formation gets a line of its own. If the other robots no longer form that formation, so do
    they. None if a line with `at` has an error.
    """
    lines = _Lines(analysis)
    if not lines.right:
        return None
    missing = dict(starts)
    for line in lines.placings:
        moved = {name: starts[name] for name in line.meaning.said.robots if name in starts} if line.meaning.said else {}
        for name in moved:
            missing.pop(name, None)
        first, *more = _moved(analysis, line, moved)
        lines.change(line, first)
        lines.add(line, more)
    lines.insert([line_at(name, start) for name, start in missing.items()])
    return lines.edits()


def formed(analysis: Analysis, shape: str, distance: float, facing: str) -> tuple[Edit, ...] | None:
    """Return the edits that have all robots begin in a formation, whose neighbors are `distance` meters apart.

    Robots in a circle face `in` or `out`. None if a line with `at` has an error.
    """
    lines = _Lines(analysis)
    robots = analysis.all_robots
    if not lines.right or not robots:
        return None
    size = radius_of(distance, len(robots)) if shape == "circle" else distance
    like = [each.statement.opening.size for each in lines.placings if isinstance(each.statement.opening, InFormation)]
    out = " facing out" if shape == "circle" and facing == "out" else ""
    form = f"{shape} {_number(max(size, 0.001), *like[:1])}{out}"
    line = f"{' '.join(robots)} at {form if len(robots) > 1 else '0 0'}"
    if not lines.placings:
        lines.insert([line])
    for index, placing in enumerate(lines.placings):
        if index:
            lines.remove(placing)
        else:
            lines.change(placing, line)
    return lines.edits()


def in_tempo(analysis: Analysis, tempo: float) -> tuple[Edit, ...]:
    """Return the edits that give a program this tempo, in beats per minute. A new line is above all others."""
    lines = _Lines(analysis)
    if analysis.tempos:
        lines.change(analysis.placed(analysis.tempos[0]), f"beat {tempo:.10g}")
    else:
        lines.put_above([f"beat {tempo:.10g}"])
    return lines.edits()


class _Lines:
    """The lines of a program, those with `at` among them, and the edits of them."""

    def __init__(self, analysis: Analysis) -> None:
        self._text = analysis.text
        self._end = "\r\n" if "\r\n" in analysis.text else "\n"
        self._edits: list[Edit] = []
        self._below: dict[int, list[str]] = {}  # lines to add, by the end of the line above them
        statements = [analysis.placed(index) for index in range(len(analysis.statements))]
        self._statements = [each for each in statements if each.statement.sign]
        self.placings = [each for each in self._statements if each.statement.kind == "AT"]

    @property
    def right(self) -> bool:
        """True if all lines with `at` have been read."""
        return all(each.meaning.said and each.meaning.said.poses for each in self.placings)

    def change(self, line: Placed, text: str) -> None:
        """Write a text in place of a statement; the comment after it stays."""
        span = _code(line)
        if text != self._text[slice(*span)]:
            self._edits.append(Edit(span, text))

    def remove(self, line: Placed) -> None:
        """Remove a statement, and its line if nothing else is on it."""
        code = _code(line)
        start, end = self._text.rfind("\n", 0, code.start) + 1, self._text.find("\n", code.end) + 1 or len(self._text)
        rest = self._text[start : code.start] + self._text[code.end : end]
        self._edits.append(Edit(code if rest.strip() else Span(start, end), ""))

    def add(self, line: Placed, lines: Sequence[str]) -> None:
        """Write lines below a statement."""
        if lines:
            end = self._text.find("\n", line.span.end)
            at = len(self._text) if end < 0 else end - (self._text[end - 1] == "\r")
            self._below.setdefault(at, []).extend(lines)

    def insert(self, lines: Sequence[str]) -> None:
        """Write lines below the last one with `at`, else below the opening, or above all."""
        opening = list(takewhile(lambda each: each.statement.kind in _OPENING, self._statements))
        if self.placings or opening:
            self.add((self.placings or opening)[-1], lines)
        elif lines:
            self.put_above(lines)

    def put_above(self, lines: Sequence[str]) -> None:
        """Write lines above all others."""
        first = self._text.rfind("\n", 0, self._statements[0].start) + 1 if self._statements else len(self._text)
        gap = self._end if not self._statements and self._text and not self._text.endswith("\n") else ""
        self._edits.append(Edit(Span(first, first), gap + "".join(f"{line}{self._end}" for line in lines)))

    def edits(self) -> tuple[Edit, ...]:
        added = (Edit(Span(at, at), "".join(self._end + line for line in lines)) for at, lines in self._below.items())
        return tuple(sorted([*self._edits, *added], key=lambda edit: edit.span))


def _code(line: Placed) -> Span:
    """Return the span of a statement up to its last word, without a comment."""
    return Span(line.start, line.start + line.statement.tokens[-1].end)


def _moved(analysis: Analysis, line: Placed, moved: Mapping[str, Start]) -> list[str]:
    """Return the lines that replace a line with `at` after some of its robots have moved."""
    said, node = line.meaning.said, line.statement.opening
    assert said
    before = dict(zip(said.robots, said.poses, strict=True))
    moved = {name: start for name, start in moved.items() if _rounded(start) != _rounded(_start(before[name]))}
    if not moved:
        return [line.statement.text[: _code(line).end - line.start]]
    if isinstance(node, AtPoint):
        return [line_at(name, start, node) for name, start in moved.items()]
    assert isinstance(node, InFormation)
    others = {name: pose for name, pose in before.items() if name not in moved}
    return [
        *(_formation(analysis, node, others) or [line_at(name, _start(pose)) for name, pose in others.items()]),
        *(line_at(name, start) for name, start in moved.items()),
    ]


def _formation(analysis: Analysis, node: InFormation, robots: Mapping[str, Pose]) -> list[str]:
    """Return the line that keeps robots of a formation at their places without the others; empty if there is none."""
    facing = f" facing {node.facing.text}" if node.facing else ""
    line = f"{' '.join(robots)} at {node.shape.text} {node.size.text}{facing}"
    alone = analyze(line, analysis.config).opening.places if len(robots) > 1 else {}
    if not alone:
        return []
    offsets = [(pose.x - alone[name].x, pose.y - alone[name].y) for name, pose in robots.items()]
    is_rigid = all(math.dist(one, other) < _SAME for one, other in pairwise(offsets))
    faces_alike = all(abs(pose.heading - alone[name].heading) < _SAME for name, pose in robots.items())
    if not is_rigid or not faces_alike:
        return []
    x, y = (_number(each, like) for each, like in zip(offsets[0], node.around or (None, None), strict=True))
    is_middle = not any(map(_thousandths, offsets[0]))
    return [line if is_middle else f"{line} around {x} {y}"]


def line_at(name: str, start: Start, like: AtPoint | None = None) -> str:
    """Return the line that places a robot, in the units of a line that placed it before."""
    x, y, heading = _rounded(start)
    at, by = (like.x, like.y) if like else (None, None)
    facing = f" facing {_number(heading, like.facing if like else None)}" if heading else ""
    return f"{name} at {_number(x, at)} {_number(y, by)}{facing}"


def _start(pose: Pose) -> Start:
    return pose.x, pose.y, math.degrees(pose.heading)


def _rounded(start: Start) -> Start:
    """Round a start to thousandths, with a heading above -180 and at most 180 degrees."""
    x, y, heading = start
    return _thousandths(x), _thousandths(y), _thousandths(wrapped(_thousandths(heading)))


def _thousandths(value: float) -> float:
    return round(value, 3) + 0.0  # without -0


def _number(value: float, like: Number | None = None) -> str:
    """Return a number of meters or degrees, in the unit of another one."""
    unit = like.units[0].text if like and like.units else ""
    return f"{_thousandths(value) / float(UNITS[unit].size if unit else 1):.10g}{unit}"
