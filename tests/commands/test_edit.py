"""`improv new`, and how `improv edit` begins (tests/stage/viewer/test_editor.py writes with it)."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from improv_core.services.program_file import TEMPLATE
from improv_core.stage.protocol import LONGEST_TEXT
from tests.commands.command_line import IMPROV, LIMIT, run


def test_new_makes_a_small_program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    made = [run("new"), run("new"), run("new", "mine")]
    names = ["dance.improv", "dance-2.improv", "mine.improv"]
    assert [each.stdout for each in made] == [f"made {name}\n" for name in names]
    assert {Path(name).read_text() for name in names} == {TEMPLATE}
    again = run("new", "mine.improv")
    assert (again.returncode, again.stderr.count("\n")) == (2, 1)
    assert again.stderr.startswith("improv: mine.improv: it exists already")
    assert run("check", *names).returncode == 0


@pytest.mark.parametrize(
    ("content", "options", "problem"),
    [
        (b"r $ left # \xff\n", (), "it is not UTF-8 text"),
        (b"#" * (LONGEST_TEXT + 1), (), "it is too long for the page"),
        (b"r $ left\n", ("--backend", "ros"), "the page belongs to the simulator: use --backend both"),
    ],
)
def test_what_can_not_be_edited_is_told_in_one_line(
    tmp_path: Path, content: bytes, options: tuple[str, ...], problem: str
) -> None:
    file = tmp_path / "dance.improv"
    file.write_bytes(content)
    done = run("edit", file, *options)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert problem in done.stderr
    assert file.read_bytes() == content


def test_standard_input_can_not_be_edited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = run("edit", "-")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "improv: standard input can't be edited: name a file\n"
    assert not list(tmp_path.iterdir())


def test_edit_begins_a_new_program_and_serves_each_file_at_the_same_address(tmp_path: Path) -> None:
    """A browser keeps unsaved text by address, so that it is found again."""
    addresses: list[str] = []
    for name in ("dance", "dance.improv"):
        command = [*IMPROV, "edit", name, "--backend", "sim", "--no-browser"]
        env = {**os.environ, "PYTHONUNBUFFERED": "1"}
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=tmp_path, env=env) as process:
            assert process.stdout
            lines = [next(process.stdout) for _ in range(3 if not addresses else 2)]
            assert (lines[0] == "made dance.improv\n") == (not addresses)
            addresses.append(lines[-2].partition("?")[0])
            process.terminate()
            assert process.wait(LIMIT) == 130
    assert addresses[0] == addresses[1]
    assert (tmp_path / "dance.improv").read_text() == TEMPLATE
