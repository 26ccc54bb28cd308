"""`improv check`, run as people run it."""

from __future__ import annotations

import json
from pathlib import Path

from tests.commands.command_line import SQUARE, run


def test_check_shows_the_place_of_each_mistake(broken: Path) -> None:
    done = run("check", SQUARE, broken)
    assert done.returncode == 1
    assert done.stdout.splitlines() == [
        f"{broken}:2:5: error[unclosed-bracket] close this bracket with `)`",
        "    r $ (forward 😀 foward",
        "        ^",
        f"{broken}:2:16: error[unknown-name] `foward` is not defined: did you mean `forward`?",
        "    r $ (forward 😀 foward",
        "                    ^^^^^^",
    ]
    assert done.stderr == ""


def test_check_as_json_counts_from_0_in_code_points(broken: Path) -> None:
    done = run("check", "--format", "json", broken)
    (line,) = map(json.loads, done.stdout.splitlines())
    assert line["file"] == str(broken)
    assert line["ok"] is False
    assert line["diagnostics"][1]["range"] == {
        "start": {"line": 1, "character": 15},
        "end": {"line": 1, "character": 21},
    }


def test_files_that_can_not_be_read_are_named_and_the_others_still_told(broken: Path, tmp_path: Path) -> None:
    latin = tmp_path / "latin.improv"
    latin.write_bytes(b"# caf\xe9\n")
    done = run("check", tmp_path / "none.improv", latin, tmp_path, broken)
    assert done.returncode == 2
    assert len(done.stdout.splitlines()) == 2 * 3
    assert done.stderr.splitlines() == [
        f"improv: {tmp_path / 'none.improv'}: no such file or directory",
        f"improv: {latin}: it is not UTF-8 text",
        f"improv: {tmp_path}: is a directory",
    ]
