"""Diagnostics drawn as carets under the source, so that a test shows what a person would see."""

from __future__ import annotations

import re
from textwrap import dedent

from improv_core.diagnostics import Severity
from improv_core.program import room
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.joint_check import check_joints
from improv_core.robots.config import read_robots

_LOUD = (Severity.ERROR, Severity.WARNING)
_CARETS = re.compile(r" *\^+ [a-z-]+: ")


def check(expected: str, *, hints: bool = False, robots: str = "", in_room: bool = False) -> Analysis:
    """Analyze the lines without carets, for the robots of an `improv.toml`; what is drawn must be all lines.

    Errors and warnings, and with `hints` all else too; `in_room`, also whom robots meet, what they
    hit, and what joints can't do.
    """
    expected = dedent(expected).strip("\n")
    source = "\n".join(line for line in expected.split("\n") if not _CARETS.match(line))
    analysis = analyze(source, read_robots(robots))
    assert drawn(analysis, hints=hints, in_room=in_room) == expected
    return analysis


def drawn(analysis: Analysis, *, hints: bool, in_room: bool = False) -> str:
    """The source, and under each line the diagnostics that begin in it: `^^^^ code: message`."""
    report = room.check(analysis) if in_room else None
    joints = check_joints(analysis) if in_room else ()
    diagnostics = [*analysis.diagnostics, *(report.diagnostics if report else ()), *joints]
    rows = []
    for number in range(len(analysis.lines.starts)):
        rows.append(analysis.lines.line(number))
        for diagnostic in diagnostics:
            start = analysis.lines.position(diagnostic.span.start)
            end = min(diagnostic.span.end, analysis.lines.end(number))
            if start.line == number and (hints or diagnostic.severity in _LOUD):
                carets = "^" * max(end - diagnostic.span.start, 1)
                rows.append(f"{' ' * start.column}{carets} {diagnostic.code}: {diagnostic.message}")
    return "\n".join(rows)
