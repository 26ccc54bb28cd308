"""Finds what is wrong with programs on disk, in a process of its own.

A thread would hold Python's lock while a busy machine lets it wait, and typing would wait with it.
"""

from __future__ import annotations

import json
import pickle
import sys
import threading
from base64 import b64decode, b64encode
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from lsprotocol import types

from improv_core.child import Child, Policy
from improv_core.program.analysis import analyze
from improv_core.program.files import ReadError, read_program
from improv_core.robots.config import Robots
from improv_core.stage.lines import own_output
from improv_ls import to_lsp
from improv_ls.positions import Encoding
from improv_ls.to_lsp import DiagnosticSupport

ANSWER_LIMIT = 120.0
"""Seconds that checking a few programs may take on a busy machine; a process that needs more counts as hung."""
POLICY = Policy(1.0)


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
        self._child: Child | None = None

    def check(self, programs: Sequence[ProgramFile]) -> list[list[types.Diagnostic]]:
        """The diagnostics of each program; none for one that can't be read. Blocks; raises EOFError or OSError if the
        process has ended, or has hung and was killed."""
        if not self._child:
            self._child = Child([sys.executable, "-m", "improv_ls.checker"], POLICY)
        patience = threading.Timer(self.limit, self._child.kill)
        patience.daemon = True
        patience.start()
        try:
            self._child.write(json.dumps(_packed((programs, *self.taken))).encode() + b"\n")
            found: list[list[types.Diagnostic]] = _unpacked(self._child.read()[0])
        finally:
            patience.cancel()
        return found

    def close(self) -> None:
        if self._child:
            self._child.kill()
            self._child.close_input()
            self._child.wait()


def _serve() -> None:
    """Answer what is asked on standard input, until it is closed."""
    say: Callable[[str], None] = own_output()
    for line in sys.stdin.buffer:
        programs, encoding, support = _unpacked(line)
        say(_packed([diagnostics_in(each, encoding, support) for each in programs]))


def _packed(value: object) -> str:
    return b64encode(pickle.dumps(value)).decode()


def _unpacked(line: bytes) -> Any:
    return pickle.loads(b64decode(json.loads(line)))


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
