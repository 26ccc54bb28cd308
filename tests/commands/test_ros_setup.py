"""`improv ros setup` on machines on which it fails: one line gives the reason, and nothing is left that counts as
good."""

from __future__ import annotations

import os
import platform
import re
import signal
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
import tomllib
from packaging.requirements import Requirement

from improv_core.commands.ros_setup import set_up
from improv_core.ipc.child import Child, Policy
from improv_core.outputs.ros.setup import environment, setup
from improv_core.outputs.ros.setup.environment import PYTHONS, REQUIREMENTS, SetupError, unsuited
from tests.commands.command_line import LIMIT, program
from tests.processes import ours
from tests.traps import PYTHONPATHS, Traps

ELSEWHERE = "source a ROS 2 (`source /opt/ros/…/setup.bash`), or set IMPROV_ROS_PYTHON to a Python with rclpy"
NOWHERE = {"PIP_INDEX_URL": "http://127.0.0.1:9/", "PIP_RETRIES": "1", "PIP_CONFIG_FILE": os.devnull}


@pytest.fixture(autouse=True)
def place(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The folder of the environment, on a machine that ROS 2's wheels support."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.setattr(setup, "unsuited", lambda: None)
    return tmp_path / "improv" / "ros"


def problem() -> str:
    """Return the reason why it can't be set up."""
    with pytest.raises(SetupError) as raised:
        set_up(lambda line: None)
    assert "\n" not in str(raised.value)
    return str(raised.value)


def python(path: Path, script: str) -> str:
    """Make a Python that runs a shell script."""
    return str(program(path, f"PATH=/usr/bin:/bin\n{script}"))


def environment_maker(folder: Path, pip: str) -> str:
    """Make a Python whose environments have this shell script as `pip`. It does everything else as ours does."""
    installed = python(folder / "pip", pip)
    make = f'[ "$3" = venv ] || exec {sys.executable} "$@"; mkdir -p "$4/bin"; cp {installed} "$4/bin/python"'
    return python(folder / "python", make)


def test_a_python_without_venv_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, place: Path) -> None:
    bare = python(
        tmp_path / "python", "echo 'not created successfully because ensurepip is not'; echo available.; exit 1"
    )
    monkeypatch.setattr(sys, "executable", bare)
    assert problem() == (
        f"{bare} cannot make virtual environments: install its venv module (on Debian and Ubuntu "
        f"`sudo apt install python3.{sys.version_info.minor}-venv`), then run `improv ros setup` again"
    )
    assert not place.exists()


def test_an_installer_that_hangs_is_given_up_on(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(environment, "QUIET_LIMIT", 0.1)
    monkeypatch.setattr(sys, "executable", python(tmp_path / "python", f"exec sleep {LIMIT}"))
    assert "cannot make a virtual environment (nothing happened for 0.1 s)" in problem()
    assert not ours(f"sleep\0{LIMIT}")


def test_a_failure_of_pip_is_one_line(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, place: Path) -> None:
    why = "Could not install packages due to an OSError: [Errno 28] No space left on device"
    monkeypatch.setattr(sys, "executable", environment_maker(tmp_path, f"echo 'ERROR: {why}'; exit 1"))
    assert problem() == f"pip could not install ROS 2 ({why}): run `improv ros setup` again, or {ELSEWHERE}"
    assert not place.exists()


def test_a_place_that_can_not_be_written(place: Path) -> None:
    place.parent.write_text("a file where a folder should be")
    assert problem().startswith(f"{place}: not a directory: ")


@pytest.mark.slow("makes a virtual environment")
@pytest.mark.timeout(300)
def test_without_a_network_and_without_modules_of_the_current_folder(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, place: Path
) -> None:
    for name, value in NOWHERE.items():
        monkeypatch.setenv(name, value)
    traps = Traps(tmp_path)
    traps.enter(monkeypatch, PYTHONPATHS[-1])
    assert problem() == "cannot reach PyPI: connect to the network, then run `improv ros setup` again"
    assert not place.exists()
    assert traps.imported == []


@pytest.mark.parametrize("minor", range(PYTHONS[0], PYTHONS[1] + 1))
def test_the_list_pins_what_the_extra_asks_for(minor: int) -> None:
    text = REQUIREMENTS.read_text(encoding="utf-8")
    assert "://" not in text
    pinned: dict[str, str] = {}
    for line in re.sub(r"^#.*\n|\\\n", "", text, flags=re.MULTILINE).splitlines():
        written, *hashes = line.split(" --hash=")
        assert hashes
        assert all(re.fullmatch(r"sha256:[0-9a-f]{64} *", each) for each in hashes)
        requirement = Requirement(written)
        if not requirement.marker or requirement.marker.evaluate({"python_full_version": f"3.{minor}.0"}):
            assert requirement.name not in pinned
            (exact,) = re.findall(r"^==([\w.]+)$", str(requirement.specifier))
            pinned[requirement.name] = exact
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    for asked in map(Requirement, project["optional-dependencies"]["ros"]):
        assert asked.specifier.contains(pinned[asked.name])
    assert {"ros-rclpy", "ros-geometry-msgs", "ros-std-srvs", "ros-rmw-fastrtps-cpp", "numpy"} <= pinned.keys()


def test_machines_without_wheels_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(platform, "system", lambda: "Linux")
    monkeypatch.setattr(platform, "libc_ver", lambda: ("glibc", "2.39"))
    monkeypatch.setattr(platform, "machine", lambda: "aarch64")
    monkeypatch.setattr(platform, "python_version", lambda: "3.13.1")
    these = "ROS 2's packages on PyPI are for CPython 3.10 to 3.14 on Linux (x86_64, glibc), and this is"
    assert unsuited() == f"{these} CPython 3.13.1 on Linux (aarch64): {ELSEWHERE}"
    monkeypatch.setattr(platform, "machine", lambda: "x86_64")
    assert unsuited() is None
    monkeypatch.setattr(sys, "version_info", (3, 15, 0))
    monkeypatch.setattr(platform, "python_version", lambda: "3.15.0")
    assert unsuited() == f"{these} CPython 3.15.0 on Linux (x86_64): {ELSEWHERE}"


def test_an_interrupt_while_an_installer_starts_ends_it(
    place: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def start(command: Sequence[str], policy: Policy) -> Child:
        child = Child(command, policy)
        while not ours(f"sleep\0{LIMIT}"):
            os.sched_yield()
        signal.raise_signal(signal.SIGINT)
        return child

    monkeypatch.setattr(sys, "executable", python(tmp_path / "python", f"exec sleep {LIMIT}"))
    monkeypatch.setattr(environment, "Child", start)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    with pytest.raises(KeyboardInterrupt):
        environment.make(place, lambda line: None)
    signal.signal(signal.SIGINT, before)
    assert not ours(f"sleep\0{LIMIT}")


@pytest.mark.slow("makes an environment")
@pytest.mark.skipif(unsuited() is not None, reason="ROS 2 has no wheels for this machine")
def test_an_interrupted_setup_leaves_nothing(tmp_path: Path, place: Path) -> None:
    started = tmp_path / "started"
    os.mkfifo(started)
    own = environment_maker(tmp_path, f"echo > {started}; exec sleep {LIMIT}")
    code = f"import sys; sys.executable = {own!r}; from improv_core.__main__ import main; main()"
    command = [sys.executable, "-u", "-c", code, "ros", "setup"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    started.read_text()  # once pip works
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=LIMIT)
    assert process.returncode == 130
    assert out.startswith("Installing ROS 2 Jazzy's Python packages")
    assert err == "improv: interrupted: run `improv ros setup` again\n"
    assert not place.exists()
