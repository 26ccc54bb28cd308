"""`improv transcribe`, run as people run it."""

from __future__ import annotations

import math
import re
import signal
import subprocess
from pathlib import Path
from random import Random

import pytest

from improv_core.program.analysis import analyze
from improv_core.program.compiler import starts_of
from improv_core.score.motion import Pose
from tests.commands.command_line import IMPROV, LIMIT, run, written
from tests.processes import lines_until
from tests.transcription.test_transcribe import path_of


@pytest.fixture
def table(tmp_path: Path) -> Path:
    rows = [
        f"{place.time},{place.x},{place.y},{place.heading}" for place in path_of("a $ repeat 4 (forward left)")["a"]
    ]
    return written(tmp_path, "\n".join(["t_s,x_m,y_m,yaw_rad", *rows]), "ada.csv")


def test_a_table_becomes_words_that_keep_their_start_beside_other_robots(table: Path) -> None:
    done = run("transcribe", table)
    assert (done.returncode, done.stdout) == (0, "ada at 0 0\n\nada $ repeat 4 (forward left)\n")
    beside = analyze(f"bo $ left\ncy $ left\n{done.stdout}")
    assert starts_of(beside)["ada"] == Pose()
    *_, tempo, off = done.stderr.splitlines()  # it may have said that it searches
    assert off == "improv: ada is at most 0 cm and 0° off"
    assert tempo.startswith(
        "improv: its tempo is 60: in a program with, say, `beat 90`, put its words into `slow 90/60 (…)`"
    )
    there = path_of("beat 90\nada $ slow 90/60 (repeat 4 (forward left))\n")["ada"]
    assert [place.time for place in there] == [place.time for place in path_of(done.stdout)["ada"]]
    assert math.dist(there[30][1:3], path_of(done.stdout)["ada"][30][1:3]) < 1e-9


def test_a_new_file_is_written_and_no_other(table: Path) -> None:
    output = table.with_suffix(".improv")
    assert run("transcribe", table, "-o", output, "--robot", "bo").stdout == ""
    assert output.read_text() == "bo $ repeat 4 (forward left)\n"
    table.unlink()  # the file is refused before anything else
    done = run("transcribe", table, "-o", output)
    assert (done.returncode, done.stderr) == (2, f"improv: {output} exists already: name a new file\n")


def test_a_recording_of_commands_becomes_its_program(tmp_path: Path) -> None:
    program = written(tmp_path, "ada $ repeat 3 (forward left) backward\n")
    run("record", program, "-o", tmp_path / "dance.mcap")
    assert "ada $ repeat 3 (forward left) backward" in run("transcribe", tmp_path / "dance.mcap").stdout


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["--tolerance", "3"], "3 is no length above 0"),
        (["--scale", "nan"], "'nan' is no number."),
        (["--robot", "zoe"], ""),
    ],
)
def test_wrong_arguments_are_one_line(table: Path, arguments: list[str], line: str) -> None:
    both = written(table.parent, table.read_text(), "bo.csv")
    done = run("transcribe", table, both, *arguments)
    assert done.returncode == 2
    assert (line or "no robot is named zoe: there are ada, bo") in done.stderr


@pytest.mark.slow("a search takes seconds")
def test_ctrl_c_ends_a_long_search_with_the_best_program_so_far(tmp_path: Path) -> None:
    dice, heading, x, y, rows = Random(1), 0.0, 0.0, 0.0, ["t_s,x_m,y_m,yaw_rad"]
    for sample in range(2000):
        heading += dice.gauss(0, 0.3)
        x, y = x + 0.05 * math.cos(heading), y + 0.05 * math.sin(heading)
        rows.append(f"{sample / 20},{x},{y},{heading}")
    table = written(tmp_path, "\n".join(rows), "ada.csv")
    command = [*IMPROV, "transcribe", str(table)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        lines_until("still searching; Ctrl-C takes the best so far", process.stderr)
        process.send_signal(signal.SIGINT)
        text, said = process.communicate(timeout=LIMIT)
    assert (process.returncode, "ada $ " in text) == (0, True)
    (off,) = re.findall(r"at most ([\d.,]+) cm", said)
    assert float(off.replace(",", "")) > 100, "the search has gone on to better programs, which are less than 20 cm off"


@pytest.mark.parametrize(
    ("path", "options", "program"),
    [
        ("M0 0h4v-4h-4z", [], "ada at 0 0\n\nada $ repeat 3 (slow 4 forward 4m left) slow 4 forward 4m\n"),
        (
            "M0 0h4v-4h-4z",
            ["--tempo", "30"],
            "beat 30\nada at 0 0\n\nada $ repeat 3 (forward forward left) forward forward\n",
        ),
        ("M0 0A2 2 0 0 0 4 0", [], "ada at 0 0 facing -90\n\nada $ slow 20 left 180deg radius 2m\n"),
        ("M2 0A2 2 0 1 0 2 4 2 2 0 1 0 2 0", [], "ada at 2 0 facing -180\n\nada $ slow 20 left 360deg radius 2m\n"),
    ],
)
def test_a_drawing_becomes_movements_of_whole_beats(
    tmp_path: Path, path: str, options: list[str], program: str
) -> None:
    drawing = written(tmp_path, f'<svg><path d="{path}"/></svg>', "ada.svg")
    assert run("transcribe", drawing, *options).stdout == program


def test_a_short_drawing_of_many_movements_gets_a_faster_tempo(tmp_path: Path) -> None:
    drawing = written(tmp_path, '<svg><path d="M0 0h4v-4h-4z"/></svg>', "ada.svg")
    assert run("transcribe", drawing, "--seconds", "3").stdout.startswith("beat 140\n")  # seven movements
