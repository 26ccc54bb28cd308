"""`improv play --fast`: what became of a dance, without waiting for it."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from textwrap import dedent

import pytest

LIMIT = 60
PLAY = [sys.executable, "-u", "-m", "improv_core", "play", "--fast"]


def check(
    folder: Path, program: str, robots: Mapping[str, tuple[float, float]], *options: str, toml: str = ""
) -> subprocess.CompletedProcess[str]:
    """Play a program; where its robots end, x and y in metres."""
    (folder / "dance.improv").write_text(program)
    (folder / "improv.toml").write_text(dedent(toml))
    command = [*PLAY, str(folder / "dance.improv"), "--report", "json", *options]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert {name: (pose["x"], pose["y"]) for name, pose in report["robots"].items()} == {
        name: pytest.approx(place, abs=0.01) for name, place in robots.items()
    }
    return done


def test_an_hour_takes_no_hour(tmp_path: Path) -> None:
    done = check(tmp_path, "r $ repeat 1800 (forward left)\n", {"r": (0, 0)})
    assert json.loads(done.stdout)["seconds"] == 3600
    assert done.stderr == ""


def test_what_never_ends_is_played_for_so_long(tmp_path: Path) -> None:
    done = check(tmp_path, "r $ repeat forward\n", {"r": (7, 0)}, "--for", "3.5")
    assert json.loads(done.stdout)["seconds"] == 3.5


def test_the_world_is_that_of_the_robots_file(tmp_path: Path) -> None:
    toml = """
        [world]
        size = [6, 4]
        [robots.a]
        start = { x = -2 }
    """
    done = check(tmp_path, "a $ repeat 4 forward\n", {"a": (2.7, 0)}, toml=toml)
    assert done.stderr == "improv: a bumped into something that stands there: give them more room, or other ways\n"


def test_a_bump_at_the_very_end_is_told(tmp_path: Path) -> None:
    toml = "[world]\nwalls = [[2.2, -1, 2.2, 1]]\n"
    assert "a bumped" in check(tmp_path, "a $ forward\n", {"a": (1.9, 0)}, toml=toml).stderr


def test_motors_are_told_of_once_they_stand(tmp_path: Path) -> None:
    toml = '[profiles.base]\nstep = 1\ndynamics = "motors"\n[robots.a]\nprofile = "base"\n'
    # At 1 m/s² the way of speeding up is missing at the end of the beat; braking makes up for it.
    check(tmp_path, "a $ forward\n", {"a": (1, 0)}, toml=toml)


@pytest.mark.parametrize(
    ("program", "options", "problem"),
    [
        ("a $ repeat forward\n", [], "this program never ends: say how much of it to play, as in `--for 60` (seconds)"),
        ("a $ forward\n", ["--backend", "ros"], "--fast is for the simulator: robots can't be hurried"),
    ],
)
def test_what_can_not_be_done_is_said(tmp_path: Path, program: str, options: list[str], problem: str) -> None:
    path = tmp_path / "dance.improv"
    path.write_text(program)
    done = subprocess.run([*PLAY, str(path), *options], capture_output=True, text=True, timeout=LIMIT)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"improv: {problem}\n")


def test_a_dance_can_not_last_nan_seconds(tmp_path: Path) -> None:
    (tmp_path / "dance.improv").write_text("a $ repeat forward\n")
    command = [*PLAY, str(tmp_path / "dance.improv"), "--for", "nan"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT)
    assert done.returncode == 2
    assert "nan is no number of seconds." in done.stderr


def test_ctrl_c_ends_it(tmp_path: Path) -> None:
    path = tmp_path / "dance.improv"
    path.write_text("a $ repeat [forward left]\n")
    (tmp_path / "improv.toml").write_text("[world]\nsize = [2, 2]\n")
    with subprocess.Popen([*PLAY, str(path), "--for", "1e9"], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr
        assert process.stderr.readline().startswith("improv: a bumped")
        process.send_signal(signal.SIGINT)
        assert process.wait(LIMIT) == -signal.SIGINT  # for a shell 130
