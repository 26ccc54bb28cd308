"""`improv compile`, run as people run it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.files import robots_near
from tests.commands.command_line import EXAMPLES, REACTING, SQUARE, run, written


def test_compile_prints_one_object_for_each_file(tmp_path: Path) -> None:
    program = written(tmp_path, "beat 92.5\nr1 $ slow 7/2 forward\nr2 $ repeat [forward left]\n")
    done = run("compile", program, SQUARE, "--max-segments", "3")
    first, second = map(json.loads, done.stdout.splitlines())
    assert done.returncode == 0
    assert list(first) == ["file", "ok", "beat", "robots", "diagnostics"]
    assert (first["file"], first["ok"], first["beat"]) == (str(program), True, 92.5)
    assert first["robots"]["r1"]["beats"] == "7/2"
    assert first["robots"]["r1"]["seconds"] == pytest.approx(3.5 * 60 / 92.5)
    endless = first["robots"]["r2"]
    assert (endless["beats"], endless["seconds"], endless["endless"], endless["truncated"]) == (None, None, True, True)
    assert [segment[0] for segment in endless["segments"]] == pytest.approx([0, 30 / 92.5, 60 / 92.5])
    assert second["robots"]["turtle1"]["truncated"] is True


def test_compile_assumes_that_nothing_is_sensed_or_what_a_script_says(tmp_path: Path) -> None:
    program, script = tmp_path / "dance.improv", tmp_path / "senses.json"
    program.write_text("r $ (until not near repeat forward) until bump repeat left\nbo $ left\n")
    script.write_text('[{"sense": "near", "robot": "r", "from": 0, "to": 2.25}, {"sense": "bump", "from": 5}]')
    robots = json.loads(run("compile", program).stdout)["robots"]
    assert (robots["r"]["open"], robots["r"]["beats"], robots["r"]["endless"]) == (True, None, True)
    assert [segment[0] for segment in robots["r"]["segments"]] == [0, 1]
    assert (robots["bo"]["open"], robots["bo"]["beats"]) == (False, "1")
    done = run("compile", program, "--senses", script)
    robots = json.loads(done.stdout)["robots"]
    assert [segment[:3] for segment in robots["r"]["segments"]] == [[0, 2.25, 2], [2.25, 0.75, 0], [3, 2, 0], [5, 1, 0]]
    assert (robots["r"]["beats"], robots["r"]["endless"], robots["r"]["truncated"]) == ("6", False, False)
    script.write_text('[{"sense": "near"}]')
    done = run("compile", program, "--senses", script)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"improv: {script}: entry 1: write `sense`, `from`")


def test_examples_are_right_and_say_first_what_they_show() -> None:
    texts = {path: path.read_text(encoding="utf-8") for path in (*EXAMPLES, *REACTING)}
    assert len(EXAMPLES) >= 10
    assert [path for path, text in texts.items() if analyze(text, robots_near(path.parent)).diagnostics] == []
    assert [path for path, text in texts.items() if not text.startswith("# ")] == []


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_in_examples_robots_meet_nobody(path: Path) -> None:
    done = run("play", "--fast", "--for", "60", path)
    assert (done.returncode, done.stderr) == (0, "")
