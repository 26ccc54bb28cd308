"""The private environment of `improv ros setup`: ROS 2's wheels from PyPI, installed with pip."""

from __future__ import annotations

import platform
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from improv_core import LineError
from improv_core.ipc.child import Child, Policy
from improv_core.outputs.ros.setup.interpreter import PROVEN, VARIABLE

REQUIREMENTS = Path(__file__).with_name("requirements.txt")
"""Every package to install, with its version and the hashes of its wheels; tests/ros/pin.sh renews it."""
PYTHONS = (10, 14)
"""The minor versions of CPython 3 that ROS 2's wheels support, first and last (PyPI, ros-rclpy 7.1)."""
DOWNLOAD, SIZE = 75, 270
"""Megabytes to download, and the size of the environment on disk, as measured with ros-rclpy 7.1.6 and numpy 2.4."""
ELSEWHERE = f"source a ROS 2 (`source /opt/ros/…/setup.bash`), or set {VARIABLE} to a Python with rclpy"
QUIET_LIMIT = 1800.0
"""Seconds that an installer may print nothing. It doesn't show the progress of a download, which may be slow."""
POLICY = Policy(10.0, errors=subprocess.STDOUT)
AGAIN = "run `improv ros setup` again"

Say = Callable[[str], object]


class SetupError(LineError):
    """Setting up ROS 2 failed. The message is one plain line that says what to do."""


def make(place: Path, say: Say) -> None:
    """Make the environment from scratch, with the wheels in the list and nothing else. Raises SetupError."""
    try:
        (place / PROVEN).unlink(missing_ok=True)  # first, because the environment is incomplete from here on
        if place.exists():
            shutil.rmtree(place)
        place.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        problem = (error.strerror or "it cannot be made").lower()
        raise SetupError(f"{place}: {problem}: make it writable, then {AGAIN}") from None
    # With -I, Python ignores the current folder and PYTHONPATH, which a sourced ROS sets.
    _run([sys.executable, "-I", "-m", "venv", str(place)], _venv_problem, lambda line: None)
    pip = [str(place / "bin" / "python"), "-I", "-m", "pip", "install", "--no-input", "--disable-pip-version-check"]
    # Only wheels: building a package from source runs code and downloads build tools, both without known hashes.
    listed = ["--require-hashes", "--only-binary", ":all:", "--no-deps", "--requirement", str(REQUIREMENTS)]
    _run([*pip, "--progress-bar", "off", *listed], _pip_problem, _tell_progress(say))


def unsuited() -> str | None:
    """The reason why ROS 2's wheels can't be installed on this machine, and what to do instead; None if they can."""
    least, most = PYTHONS
    is_cpython = platform.python_implementation() == "CPython" and (3, least) <= sys.version_info[:2] <= (3, most)
    if is_cpython and (sys.platform, platform.machine(), platform.libc_ver()[0]) == ("linux", "x86_64", "glibc"):
        return None
    theirs = f"CPython 3.{least} to 3.{most} on Linux (x86_64, glibc)"
    here = f"{platform.python_implementation()} {platform.python_version()} on {platform.system()}"
    return f"ROS 2's packages on PyPI are for {theirs}, and this is {here} ({platform.machine()}): {ELSEWHERE}"


def _run(command: Sequence[str], problem: Callable[[Sequence[str]], SetupError], tell: Say) -> None:
    """Run a command and pass each line that it prints to `tell`; if it fails, raise `problem` of the lines."""
    lines: list[str] = []
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])  # an interrupt now would leave it running
    child = Child(command, POLICY)
    try:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        child.close_input()
        while said := child.read(QUIET_LIMIT):
            for line in said:
                lines.append(line.decode(errors="replace").rstrip())
                tell(lines[-1])
        lines.append(f"nothing happened for {QUIET_LIMIT:g} s")
        child.kill()
    except EOFError:
        pass
    except BaseException:
        child.kill()
        child.wait()
        raise
    if child.wait() != 0:
        raise problem(lines)


def _tell_progress(say: Say) -> Say:
    """Return a function that reports only the packages in pip's output: `ros-rclpy 7.1.6, 2.6 MB`."""

    def tell(line: str) -> None:
        if got := re.match(r"\s+Downloading ([^/\s-]+)-([^-\s]+)-\S+\.whl \((.+)\)", line):
            name, version, size = got.groups()
            say(f"  {name.replace('_', '-')} {version}, {size}")
        elif line.startswith("Installing collected packages"):
            say(f"  unpacking {line.count(',') + 1} packages")

    return tell


def _venv_problem(lines: Sequence[str]) -> SetupError:
    said = "\n".join(lines)
    if "ensurepip" in said or "No module named venv" in said:
        package = f"python3.{sys.version_info.minor}-venv"
        return SetupError(
            f"{sys.executable} cannot make virtual environments: install its venv module "
            f"(on Debian and Ubuntu `sudo apt install {package}`), then {AGAIN}"
        )
    return SetupError(f"{sys.executable} cannot make a virtual environment ({_last(lines)}): {ELSEWHERE}")


_OFFLINE = ("Retrying (", "Max retries", "ConnectionError", "Temporary failure in name resolution", "timed out")


def _pip_problem(lines: Sequence[str]) -> SetupError:
    said = "\n".join(lines)
    if any(sign in said for sign in _OFFLINE):
        return SetupError(f"cannot reach PyPI: connect to the network, then {AGAIN}")
    errors = [line.removeprefix("ERROR: ") for line in lines if line.startswith("ERROR: ")]
    return SetupError(f"pip could not install ROS 2 ({_last(errors or lines)}): {AGAIN}, or {ELSEWHERE}")


def _last(lines: Sequence[str]) -> str:
    return next((line.strip() for line in reversed(lines) if line.strip()), "no error message")
