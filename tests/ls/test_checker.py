"""The process that checks programs on disk."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from improv_core.robots.config import read_robots
from improv_ls.checker import Checker, ProgramFile
from improv_ls.to_lsp import DiagnosticSupport
from tests.processes import ours

LIMIT = 60.0


@pytest.fixture
def program(tmp_path: Path) -> ProgramFile:
    path = tmp_path / "dance.improv"
    path.write_text("ada $ forwart\n", encoding="utf-8")
    return ProgramFile(path.as_uri(), path, read_robots(""))


@pytest.fixture
def checker() -> Iterator[Checker]:
    checker = Checker("utf-16", DiagnosticSupport(True, True, True), LIMIT)
    yield checker
    checker.close()


def test_a_program_on_disk_is_checked(checker: Checker, program: ProgramFile) -> None:
    [[found]] = checker.check([program])
    assert found.code == "unknown-name"


def test_a_hung_process_is_given_up_on(checker: Checker, program: ProgramFile) -> None:
    checker.check([program])
    for process in ours("improv_ls.checker"):
        os.kill(process, signal.SIGSTOP)
    checker.answerer.limit = 0.1
    with pytest.raises(EOFError):
        checker.check([program])
