"""Finds the errors of programs on disk, in a separate process.

A thread would hold Python's lock even while the system doesn't run it, and typing would lag.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from improv_core.diagnostics import Diagnostic
from improv_core.program import room
from improv_core.program.analysis import analyze
from improv_core.program.files import ReadError, read_program
from improv_core.protocol.json_lines import own_output
from improv_core.robots.config import Robots
from improv_core.text import LineIndex
from improv_ls.asking import ANSWER_LIMIT, Answerer, packed, unpacked


class ProgramFile(NamedTuple):
    """A file, and the robots of its program."""

    uri: str
    path: Path
    robots: Robots


class Findings(NamedTuple):
    """Errors of a program, and the lines of its text."""

    lines: LineIndex
    diagnostics: Sequence[Diagnostic]


class Checker:
    """Checks programs. The process starts when there is something to check, and ends with `close`."""

    def __init__(self, limit: float = ANSWER_LIMIT) -> None:
        self.answerer = Answerer("improv_ls.checker", limit)

    def check(self, programs: Sequence[ProgramFile]) -> list[Findings | None]:
        """Return the findings for each program; None if there are none, or it can't be read. Blocks; raises EOFError or
        OSError if the process has ended, or has hung and was killed."""
        return [each and Findings(*each) for each in self.answerer.ask(programs)]

    def close(self) -> None:
        self.answerer.close()


def _serve() -> None:
    """Answer the questions from standard input, until it is closed."""
    say: Callable[[str], None] = own_output()
    for line in sys.stdin.buffer:
        # As tuples: the classes of this module are those of `__main__` here.
        say(packed([found and tuple(found) for found in map(found_in, unpacked(line))]))


def found_in(program: ProgramFile) -> Findings | None:
    """Return the findings for a program on disk; None if there are none, or it can't be read."""
    try:
        analysis = analyze(read_program(program.path), program.robots)
    except ReadError:
        return None
    report = room.check(analysis)
    found = sorted([*analysis.diagnostics, *(report.diagnostics if report else ())], key=lambda each: each.span)
    return Findings(analysis.lines, found) if found else None


if __name__ == "__main__":
    _serve()
