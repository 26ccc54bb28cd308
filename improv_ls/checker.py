"""Finds what is wrong with programs on disk, in a process of its own.

A thread would hold Python's lock while a busy machine lets it wait, and typing would wait with it.
"""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from lsprotocol import types

from improv_core.playback.isolation import isolated
from improv_core.program.analysis import analyze
from improv_core.program.files import ReadError, read_program
from improv_core.robots.config import Robots
from improv_ls import to_lsp
from improv_ls.positions import Encoding
from improv_ls.to_lsp import DiagnosticSupport

ANSWER_LIMIT = 120.0
"""Seconds that checking a few programs may take on a busy machine; a process that needs more counts as hung."""


class ProgramFile(NamedTuple):
    """A file, and the robots that its program is for."""

    uri: str
    path: Path
    robots: Robots


class Checker:
    """Checks programs for a client. The process starts when there is something to check, and ends with `close`."""

    def __init__(self, encoding: Encoding, support: DiagnosticSupport, limit: float = ANSWER_LIMIT) -> None:
        self.taken = encoding, support
        self.limit = limit
        self._process: subprocess.Popen[bytes] | None = None

    def check(self, programs: Sequence[ProgramFile]) -> list[list[types.Diagnostic]]:
        """The diagnostics of each program; none for one that can't be read. Blocks; raises EOFError or OSError if the
        process has ended, or has hung and was killed."""
        if not self._process:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "improv_ls.checker"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                **isolated(os.environ),
            )
        asked, answer = self._process.stdin, self._process.stdout
        assert asked
        assert answer
        patience = threading.Timer(self.limit, self._process.kill)
        patience.daemon = True
        patience.start()
        try:
            pickle.dump((programs, *self.taken), asked)
            asked.flush()
            found: list[list[types.Diagnostic]] = pickle.load(answer)
        finally:
            patience.cancel()
        return found

    def close(self) -> None:
        if self._process:
            self._process.kill()
            self._process.wait()


def _serve() -> None:
    """Answer what is asked on standard input, until it is closed."""
    with suppress(EOFError):
        while True:
            programs, encoding, support = pickle.load(sys.stdin.buffer)
            pickle.dump([diagnostics_in(each, encoding, support) for each in programs], sys.stdout.buffer)
            sys.stdout.buffer.flush()


def diagnostics_in(program: ProgramFile, encoding: Encoding, support: DiagnosticSupport) -> list[types.Diagnostic]:
    """What is wrong with a program on disk; nothing if it can't be read."""
    try:
        analysis = analyze(read_program(program.path), program.robots)
    except ReadError:
        return []
    found = analysis.diagnostics
    return [to_lsp.diagnostic(program.uri, analysis.lines, each, encoding, support) for each in found]


if __name__ == "__main__":
    _serve()
