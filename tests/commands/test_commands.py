"""The command line, run as people run it."""

from __future__ import annotations

import json
import math
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.improv"))
SQUARE = next(path for path in EXAMPLES if path.name == "square.improv")


def run(*arguments: str | Path, env: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "improv_core", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, env={**os.environ, **(env or {})})


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    path = tmp_path / "broken.improv"
    path.write_bytes("\ufeffbeat 60\r\nr $ (forward 😀 foward\r\n".encode())
    return path


def test_check_prints_a_line_for_each_mistake(broken: Path) -> None:
    done = run("check", SQUARE, broken)
    assert done.returncode == 1
    assert done.stdout.splitlines() == [
        f"{broken}:2:5: error[unclosed-bracket] close this bracket with `)`",
        f"{broken}:2:16: error[unknown-name] `foward` is not known: did you mean `forward`?",
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
    assert len(done.stdout.splitlines()) == 2
    assert done.stderr.splitlines() == [
        f"improv: {tmp_path / 'none.improv'}: no such file or directory",
        f"improv: {latin}: it is not UTF-8 text",
        f"improv: {tmp_path}: is a directory",
    ]


def test_compile_prints_one_object_for_each_file(tmp_path: Path) -> None:
    program = tmp_path / "dance.improv"
    program.write_text("beat 92.5\nr1 $ slow 7/2 forward\nr2 $ repeat [forward left]\n")
    done = run("compile", program, SQUARE, "--format", "json", "--max-segments", "3")
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


def test_compile_merges_equal_neighbors_and_ends_whatever_the_program() -> None:
    for program in ("repeat forward", "left repeat forward", "fast 1000000000 repeat 1000000000 (forward left)"):
        done = subprocess.run(
            [sys.executable, "-m", "improv_core", "compile", "/dev/stdin"],
            input=f"r $ {program}\n",
            capture_output=True,
            text=True,
            timeout=60,
        )
        assert json.loads(done.stdout)["robots"]["r"]["truncated"] is True
        assert done.returncode == 0


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_right(path: Path) -> None:
    done = run("compile", path)
    assert done.stdout
    assert json.loads(done.stdout)["diagnostics"] == []


def test_six_examples() -> None:
    assert len(EXAMPLES) >= 6


def played(path: Path, *options: str) -> Any:
    done = run("play", path, "--backend", "sim", "--no-browser", "--report", "json", *options)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_play_reports_that_a_square_leads_home() -> None:
    report = played(SQUARE)
    start, end = report["start"]["turtle1"], report["robots"]["turtle1"]
    assert math.hypot(end["x"] - start["x"], end["y"] - start["y"]) < 1e-9
    assert abs(end["heading"] - start["heading"]) < 1e-9
    assert report["seconds"] == 8


def test_play_says_what_plays(tmp_path: Path) -> None:
    program = tmp_path / "dance.improv"
    program.write_text("beat 600\nr $ forward\n")
    done = run("play", program, "--backend", "sim", "--no-browser")
    assert done.returncode == 0
    page, status = done.stdout.splitlines()
    assert page.startswith("watch it on http://127.0.0.1:")
    assert status == "▶ r 1 beat, 0.10 s at beat 600, simulator"


def test_play_of_a_wrong_program_says_why(broken: Path) -> None:
    done = run("play", broken, "--no-browser")
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 2


def test_play_says_in_one_line_why_it_can_not(tmp_path: Path) -> None:
    missing = run("play", tmp_path / "none.improv")
    assert (missing.returncode, missing.stderr.count("\n")) == (2, 1)

    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        busy = run("play", SQUARE, "--backend", "sim", "--no-browser", "--port", str(port))
    assert busy.returncode == 2
    assert busy.stderr == f"improv: the page's port {port} is taken: choose another, or 0 for any free one\n"

    without = run("play", SQUARE, "--backend", "ros", env={"IMPROV_ROS_PYTHON": sys.executable})
    assert without.returncode == 2
    assert without.stderr.startswith(f"improv: {sys.executable} has no rclpy ")
    assert without.stderr.count("\n") == 1


def test_interrupt_stops_the_robots_and_ends(tmp_path: Path) -> None:
    program = tmp_path / "dance.improv"
    program.write_text("r $ repeat forward\n")
    command = [sys.executable, "-m", "improv_core", "play", str(program), "--backend", "sim", "--no-browser"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1)
    assert process.stdout
    while not process.stdout.readline().startswith("▶"):
        assert process.poll() is None
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 130
    assert errors == ""


def test_check_needs_neither_the_server_nor_a_robot() -> None:
    code = "import sys; sys.argv = ['improv', 'check', sys.argv[1]]\nimport atexit\n"
    code += "atexit.register(lambda: print(*sys.modules))\nfrom improv_core.commands.main import main; main()"
    done = subprocess.run([sys.executable, "-c", code, str(SQUARE)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    modules = {name.split(".")[0] for name in done.stdout.split()}
    assert modules.isdisjoint({"pygls", "lsprotocol", "pymunk", "aiohttp", "rclpy", "asyncio", "watchfiles"})
