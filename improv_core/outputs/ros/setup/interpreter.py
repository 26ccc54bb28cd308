"""Finds a Python that can import rclpy. Ours usually can't (see docs/architecture.md). Standard library only."""

from __future__ import annotations

import importlib.util
import os
import shutil
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from improv_core.ipc.child import output
from improv_core.ipc.stage_process import StageError
from improv_core.outputs.ros.discovery import unsourced

VARIABLE = "IMPROV_ROS_PYTHON"
SETUP = "`improv ros setup`"
PROVEN = "proven"
"""The file that `improv ros setup` writes last. Without it, its environment isn't used."""
PROBE = "import rclpy, geometry_msgs.msg"
PROBE_LIMIT = 30.0
"""Seconds that an interpreter may take to import rclpy from a cold disk."""


class InterpreterError(StageError):
    """The requested interpreter can't be used. The message is one line that says what to do."""


@dataclass(frozen=True, slots=True)
class Interpreter:
    """A Python that can import rclpy, the environment it needs, and its origin, in words."""

    python: str
    env: Mapping[str, str]
    origin: str


def find_ros_python(setting: str | None, *, proves: bool = True) -> Interpreter | None:
    """The first Python with rclpy: the setting, IMPROV_ROS_PYTHON, this one, a sourced or installed ROS, or our own.

    None if there is none. Without any sign of ROS, it starts no process. Raises InterpreterError if the one that the
    user named can't be used. Without `proves`, it returns the likeliest one: a proof takes as long as starting a stage.
    Files of an opened project are never consulted: they could name any program.
    """
    for named, source in ((setting, "the setting improv.ros.python"), (os.environ.get(VARIABLE), VARIABLE)):
        if named:
            asked = Interpreter(named, dict(os.environ), source)
            if proves and (problem := _problem(asked)):
                raise InterpreterError(f"{named} cannot import rclpy ({problem}): correct {source} or clear it")
            return asked
    return next((each for each in _candidates() if not proves or _problem(each) is None), None)


def private_environment() -> Path:
    """The folder of the environment that `improv ros setup` creates."""
    data = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(data) / "improv" / "ros"


def _candidates() -> Iterator[Interpreter]:
    env = dict(os.environ)
    if importlib.util.find_spec("rclpy"):
        yield Interpreter(sys.executable, env, "Improv's own Python")
    if "AMENT_PREFIX_PATH" in env:
        for python in dict.fromkeys(filter(None, [shutil.which("python3"), _SYSTEM_PYTHON])):
            yield Interpreter(python, env, "the sourced ROS")
    for setup in sorted(Path(_INSTALLED).glob("*/setup.bash"), reverse=True):
        if sourced := _sourced(setup):
            yield Interpreter(_SYSTEM_PYTHON, sourced, str(setup.parent))
    own = private_environment()
    if (own / PROVEN).exists():
        yield Interpreter(str(own / "bin" / "python"), env, SETUP)


_SYSTEM_PYTHON = "/usr/bin/python3"  # the only Python that ROS's Debian packages are built for
_INSTALLED = "/opt/ros"


def _sourced(setup: Path) -> dict[str, str] | None:
    """The environment after sourcing a ROS installation, without widening discovery; None if that fails."""
    command = ["bash", "-c", 'source "$0" >/dev/null && env -0', str(setup)]
    try:
        said = output(command, PROBE_LIMIT)  # isolated: its scripts run Python
    except OSError:
        return None
    pairs = (entry.partition("=") for entry in os.fsdecode(said).split("\0") if entry)
    return unsourced({name: value for name, _, value in pairs}, os.environ)


def _problem(candidate: Interpreter) -> str | None:
    """The reason why an interpreter can't be used, or None if it can."""
    try:
        output([candidate.python, "-c", PROBE], PROBE_LIMIT, candidate.env)
    except OSError as error:
        return str(error)
    return None
