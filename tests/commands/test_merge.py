"""`improv merge`, run as people run it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.commands.command_line import run, written


@pytest.fixture
def dances(tmp_path: Path) -> Path:
    (tmp_path / "ada.improv").write_text("r $ forward\n")
    (tmp_path / "bo.improv").write_text("r $ left\n")
    return tmp_path


def test_merged_programs_are_one_that_is_right_and_formatted(dances: Path) -> None:
    done = run("merge", dances / "ada.improv", dances / "bo.improv")
    assert (done.returncode, done.stderr) == (0, "")
    assert [line for line in done.stdout.splitlines() if "$" in line] == ["ada $ forward", "bo $ left"]
    together = written(dances, done.stdout, "together.improv")
    assert run("check", together).returncode == 0
    assert run("format", "--check", together).returncode == 0


def test_lost_lines_are_reported(dances: Path) -> None:
    (dances / "bo.improv").write_text("beat 30\nbar 3\nr $ left\n")
    done = run("merge", dances / "ada.improv", dances / "bo.improv")
    assert [line.partition(": ")[0] for line in done.stderr.splitlines()] == ["improv", "improv"]


def test_a_new_file_is_written_and_no_other(dances: Path) -> None:
    output = dances / "both.improv"
    done = run("merge", dances, "-o", output)
    assert (done.returncode, done.stdout) == (0, f"merged 2 programs into {output}\n")
    before = output.read_bytes()
    done = run("merge", dances / "ada.improv", "-o", output)
    assert (done.returncode, done.stderr) == (2, f"improv: {output} exists already: name a new file\n")
    assert output.read_bytes() == before


def test_a_program_that_cannot_be_merged_is_one_line(dances: Path) -> None:
    (dances / "bo.improv").write_text("r $ lefft\n")
    done = run("merge", dances / "ada.improv", dances / "bo.improv")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
