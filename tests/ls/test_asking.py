"""The processes that check programs: on disk, and the open ones."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from improv_core.ipc.asking import Answerer
from improv_core.robots.config import read_robots
from improv_ls import checker, room_checker
from improv_ls.checker import ProgramFile
from improv_ls.room_checker import OpenProgram, Rooms
from tests.processes import ours

ROBOTS = read_robots("")
MEETING = "ada at 0 0\nbo at 1 -1 facing 90\nada $ forward\nbo $ forward\n"


def test_programs_on_disk_are_checked_until_the_process_hangs(tmp_path: Path) -> None:
    paths = [tmp_path / f"{name}.improv" for name in ("wrong", "right", "missing")]
    for path, text in zip(paths, ("ada $ forwart\n", "ada $ forward\n"), strict=False):
        path.write_text(text, encoding="utf-8")
    answerer = Answerer(checker.check)
    found, *others = (answerer.ask(ProgramFile(path, ROBOTS)) for path in paths)
    assert found
    assert [each.code for each in found.diagnostics] == ["unknown-name"]
    assert others == [None, None]
    for process in ours("improv_ls.checker"):
        os.kill(process, signal.SIGSTOP)
    answerer.limit = 0.1
    with pytest.raises(EOFError):
        answerer.ask(ProgramFile(paths[0], ROBOTS))
    answerer.close()


def test_a_killed_process_is_replaced() -> None:
    meets = OpenProgram("file:///dance.improv", MEETING, ROBOTS)
    answerer = Answerer(room_checker.look)
    assert [each.code for each in answerer.ask(meets).diagnostics] == ["meets"]
    assert answerer.ask(meets._replace(text=MEETING.replace("1 -1", "5 -1"))).diagnostics == ()
    for process in ours("improv_ls.room_checker"):
        os.kill(process, signal.SIGKILL)
    with pytest.raises((EOFError, OSError)):
        answerer.ask(meets)
    answerer.close()
    assert [each.code for each in answerer.ask(meets).diagnostics] == ["meets"]
    answerer.close()


def test_only_the_latest_programs_are_kept() -> None:
    rooms, program = Rooms(), OpenProgram("file:///0.improv", MEETING, ROBOTS)
    for number in range(30):
        assert len(rooms.look(program._replace(uri=f"file:///{number}.improv")).diagnostics) == 1
    assert len(rooms._versions) == 20
    for text, count in (("", 0), (MEETING, 1), (f"{MEETING}oops", 0), (MEETING, 1)):
        assert len(rooms.look(program._replace(text=text)).diagnostics) == count
    assert len(rooms.look(program._replace(robots=read_robots("[profiles.x]\nstep = 1"))).diagnostics) == 1
