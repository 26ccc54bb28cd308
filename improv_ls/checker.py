"""Finds what is wrong with programs on disk, in a process of its own.

A thread would hold Python's lock while a busy machine lets it wait, and typing would wait with it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from lsprotocol import types

from improv_core.program import room
from improv_core.program.analysis import analyze
from improv_core.program.files import ReadError, read_program
from improv_core.robots.config import Robots
from improv_core.stage.lines import own_output
from improv_ls import to_lsp
from improv_ls.asking import ANSWER_LIMIT, Answerer, packed, unpacked
from improv_ls.positions import Encoding
from improv_ls.to_lsp import DiagnosticSupport


class ProgramFile(NamedTuple):
    """A file, and the robots that its program is for."""

    uri: str
    path: Path
    robots: Robots


class Checker:
    """Checks programs for a client. The process starts when there is something to check, and ends with `close`."""

    def __init__(self, encoding: Encoding, support: DiagnosticSupport, limit: float = ANSWER_LIMIT) -> None:
        self.taken = encoding, support
        self.answerer = Answerer("improv_ls.checker", limit)

    def check(self, programs: Sequence[ProgramFile]) -> list[list[types.Diagnostic]]:
        """The diagnostics of each program; none for one that can't be read. Blocks; raises EOFError or OSError if the
        process has ended, or has hung and was killed."""
        found: list[list[types.Diagnostic]] = self.answerer.ask((programs, *self.taken))
        return found

    def close(self) -> None:
        self.answerer.close()


def _serve() -> None:
    """Answer what is asked on standard input, until it is closed."""
    say: Callable[[str], None] = own_output()
    for line in sys.stdin.buffer:
        programs, encoding, support = unpacked(line)
        say(packed([diagnostics_in(each, encoding, support) for each in programs]))


def diagnostics_in(program: ProgramFile, encoding: Encoding, support: DiagnosticSupport) -> list[types.Diagnostic]:
    """What is wrong with a program on disk; nothing if it can't be read."""
    try:
        analysis = analyze(read_program(program.path), program.robots)
    except ReadError:
        return []
    report = room.check(analysis)
    found = sorted([*analysis.diagnostics, *(report.diagnostics if report else ())], key=lambda each: each.span)
    return [to_lsp.diagnostic(program.uri, analysis.lines, each, encoding, support) for each in found]


if __name__ == "__main__":
    _serve()
