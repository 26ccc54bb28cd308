"""Finds the errors of programs on disk. The server asks for it in a separate process: a thread would hold Python's lock
even while the system doesn't run it, and typing would lag."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from improv_core.diagnostics import Diagnostic
from improv_core.program import room
from improv_core.program.analysis import analyze
from improv_core.program.files import ReadError, read_program
from improv_core.robots.config import Robots
from improv_core.text import LineIndex


class ProgramFile(NamedTuple):
    """A file, and the robots of its program."""

    path: Path
    robots: Robots


class Findings(NamedTuple):
    """Errors of a program, and the lines of its text."""

    lines: LineIndex
    diagnostics: Sequence[Diagnostic]


def check(program: ProgramFile) -> Findings | None:
    """Return the findings for a program; None if there are none, or it can't be read."""
    from improv_core.stage.dry_run import predict  # not in the server, which only asks

    try:
        analysis = analyze(read_program(program.path), program.robots)
    except ReadError:
        return None
    report = room.check(analysis, predict=predict)
    found = sorted([*analysis.diagnostics, *(report.diagnostics if report else ())], key=lambda each: each.span)
    return Findings(analysis.lines, found) if found else None
