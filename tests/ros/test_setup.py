"""A real `improv ros setup`: its own environment, and a Twist through it. Its wheels are from fetch.sh.

The tests make it once, through ssh, which does the same as a setup here. tests/commands/test_ros_setup.py tests the
messages of setups that fail.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from improv_core.commands import ros_setup as commands_setup
from improv_core.commands.doctor_hosts import examine_hosts
from improv_core.commands.doctor_ros import ros
from improv_core.commands.finding import BROKEN
from improv_core.hosts.probe import set_up_there
from improv_core.outputs.ros.setup import interpreter
from improv_core.outputs.ros.setup import setup as setup_here
from improv_core.outputs.ros.setup.environment import unsuited
from improv_core.score.score import Host as HostOfRobots
from tests.hosts.sshd import a_host
from tests.needs import lacking
from tests.ros.conftest import let_stages_be_late, with_limits
from tests.traps import PYTHONPATHS, Traps

INSTALL_LIMIT = 900.0
"""Seconds to unpack 75 MB on a slow machine."""
WHEELS = Path(__file__).parents[2] / ".cache" / "ros-wheels"
pytestmark = [pytest.mark.timeout(2 * INSTALL_LIMIT), pytest.mark.slow("installs ROS, and proves that it works")]


@dataclass(frozen=True)
class Machine:
    """A machine without any other ROS 2, the output of its first setup, and the doctor's later output about it."""

    data: Path
    place: Path
    said: list[str]
    examined: list[str]


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    """A machine that is set up through ssh after an earlier setup was interrupted half way."""
    if problem := unsuited():
        lacking(problem)
    if not WHEELS.is_dir():
        lacking("no wheels of ROS 2: run `sh tests/ros/fetch.sh`")
    there = {"PIP_FIND_LINKS": str(WHEELS), "PIP_NO_INDEX": "1", **with_limits()}
    there["PIP_NO_COMPILE"] = "1"  # compiling takes longer than all other steps
    said: list[str] = []
    with a_host(tmp_path_factory.mktemp("host"), there) as host, pytest.MonkeyPatch.context() as patch:
        data = host.home / "data"
        place = data / "improv" / "ros"
        (place / "bin").mkdir(parents=True)
        (place / "bin" / "python").write_text("half a Python")
        patch.setenv("XDG_CONFIG_HOME", host.env["XDG_CONFIG_HOME"])
        set_up_there("robot", commands_setup.proof(), said.append, str(host.config))
        examined = [*map(str, examine_hosts([HostOfRobots("robot")], str(host.config)))]
    return Machine(data, place, said, examined)


@pytest.fixture(autouse=True)
def here(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make this process see that machine as its own."""
    for name in ("IMPROV_ROS_PYTHON", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    let_stages_be_late(monkeypatch)
    monkeypatch.setenv("XDG_DATA_HOME", str(machine.data))
    monkeypatch.setattr(interpreter, "_INSTALLED", "/nowhere")


def test_setup_says_what_it_does_and_proves_that_it_works(machine: Machine) -> None:
    what, where, *progress, proof = machine.said
    assert what == "Installing ROS 2 Jazzy's Python packages from PyPI, each checked against its known hash,"
    assert where == f"into {machine.place}: about 75 MB to download, 270 MB on disk."
    assert any(line.startswith(("  ros-", "  unpacking ")) for line in progress)
    assert proof.startswith("ROS 2 works: a Twist was sent and received in ")


def test_stages_there_and_here_find_the_environment(machine: Machine) -> None:
    _, there, _ = machine.examined
    assert "from `improv ros setup`" in there
    found = interpreter.find_ros_python(None)
    assert found
    assert (found.python, found.origin) == (str(machine.place / "bin" / "python"), "`improv ros setup`")


def set_up() -> list[str]:
    """Return its output."""
    said: list[str] = []
    commands_setup.set_up(said.append)
    return said


def test_a_second_setup_only_tests_it_and_names_a_python_that_comes_first(
    machine: Machine, ros_python: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It runs none of the modules in the current folder."""
    traps = Traps(tmp_path)
    traps.enter(monkeypatch, os.environ["PYTHONPATH"] + PYTHONPATHS[-1])
    monkeypatch.setattr(setup_here, "make", lambda place, say: pytest.fail("it was made again"))
    monkeypatch.setenv("IMPROV_ROS_PYTHON", ros_python)
    proof, there, unused = set_up()
    assert proof.startswith("ROS 2 works: ")
    assert there == f"ROS 2 is already set up in {machine.place}."
    assert unused == f"It is not used yet: IMPROV_ROS_PYTHON takes precedence, with {ros_python}"
    assert traps.imported == []


def test_a_damaged_environment_is_rebuilt(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    (rclpy,) = machine.place.glob("lib/python3*/site-packages/rclpy")
    gone = rclpy.rename(machine.place / "rclpy")
    assert interpreter.find_ros_python(None) is None
    told = ros(None, machine.place, os.environ)
    assert (told.mark, told.what) == (BROKEN, f"the ROS 2 in {machine.place} does not work")

    def make(place: Path, say: Callable[[str], object]) -> None:
        assert place == machine.place
        gone.rename(rclpy)

    monkeypatch.setattr(setup_here, "make", make)
    first, *_, proof = set_up()
    assert first == f"The environment in {machine.place} does not work: making it again."
    assert proof.startswith("ROS 2 works: ")
