"""The process that checks programs on disk."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from improv_core.robots.config import read_robots
from improv_ls.checker import Checker, ProgramFile
from tests.processes import ours

LIMIT = 60.0


@pytest.fixture
def program(tmp_path: Path) -> ProgramFile:
    path = tmp_path / "dance.improv"
    path.write_text("ada $ forwart\n", encoding="utf-8")
    return ProgramFile(path.as_uri(), path, read_robots(""))


@pytest.fixture
def checker() -> Iterator[Checker]:
    checker = Checker(LIMIT)
    yield checker
    checker.close()


def test_programs_on_disk_are_checked_until_the_process_hangs(checker: Checker, program: ProgramFile) -> None:
    right, missing = (program.path.with_name(name) for name in ("right.improv", "missing.improv"))
    right.write_text("ada $ forward\n", encoding="utf-8")
    nothing = [ProgramFile(path.as_uri(), path, program.robots) for path in (right, missing)]
    found, *others = checker.check([program, *nothing])
    assert found
    assert [each.code for each in found.diagnostics] == ["unknown-name"]
    assert others == [None, None]
    for process in ours("improv_ls.checker"):
        os.kill(process, signal.SIGSTOP)
    checker.answerer.limit = 0.1
    with pytest.raises(EOFError):
        checker.check([program])
