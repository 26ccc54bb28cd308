"""Diagnostics drawn as carets under the source, so that a test shows what a person would see."""

from __future__ import annotations

import re
from collections.abc import Sequence
from textwrap import dedent

from improv_core.diagnostics import Diagnostic, Severity
from improv_core.program import room
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.joint_check import check_joints
from improv_core.robots.config import read_robots
from improv_core.text import LineIndex

_LOUD = (Severity.ERROR, Severity.WARNING)
_CARETS = re.compile(r" *\^+ [a-z-]+: ")


def check(expected: str, *, hints: bool = False, robots: str = "", in_room: bool = False) -> Analysis:
    """Analyze the lines without carets, for the robots of an `improv.toml`; the drawing must match all lines.

    Draws errors and warnings, with `hints` everything else too, and `in_room` also meetings and hits of robots and the
    limits of joints.
    """
    expected, source = undrawn(expected)
    analysis = analyze(source, read_robots(robots))
    assert drawn(analysis, hints=hints, in_room=in_room) == expected
    return analysis


def check_all(expected: str) -> Analysis:
    """Check as above, with all diagnostics drawn."""
    return check(expected, hints=True)


def drawn(analysis: Analysis, *, hints: bool, in_room: bool = False) -> str:
    """Return the source, and under each line the diagnostics that begin in it: `^^^^ code: message`."""
    report = room.check(analysis) if in_room else None
    joints = check_joints(analysis) if in_room else ()
    diagnostics = [*analysis.diagnostics, *(report.diagnostics if report else ()), *joints]
    return carets(analysis.lines, [each for each in diagnostics if hints or each.severity in _LOUD])


def undrawn(expected: str) -> tuple[str, str]:
    """Return a drawing without its indentation, and only its lines without carets."""
    expected = dedent(expected).strip("\n")
    return expected, "\n".join(line for line in expected.split("\n") if not _CARETS.match(line))


def carets(lines: LineIndex, diagnostics: Sequence[Diagnostic]) -> str:
    """Return a text, and under each line the diagnostics that begin in it."""
    rows = []
    for number in range(len(lines.starts)):
        rows.append(lines.line(number))
        for diagnostic in diagnostics:
            start = lines.position(diagnostic.span.start)
            if start.line == number:
                end = min(diagnostic.span.end, lines.end(number))
                marks = "^" * max(end - diagnostic.span.start, 1)
                rows.append(f"{' ' * start.column}{marks} {diagnostic.code}: {diagnostic.message}")
    return "\n".join(rows)
