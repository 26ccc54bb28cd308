"""`improv ros setup`: ROS 2's Python packages in an environment of their own, proven to carry a Twist."""

from __future__ import annotations

import contextlib
import shutil
import sys
from pathlib import Path

import click

from improv_core.commands.echo import echo
from improv_core.commands.exit_codes import INTERRUPTED, CommandError
from improv_core.commands.group import Group
from improv_core.commands.ros_environment import (
    AGAIN,
    DOWNLOAD,
    REQUIREMENTS,
    SIZE,
    Say,
    SetupError,
    make,
    unsuited,
)
from improv_core.commands.ros_proof import prove
from improv_core.playback.interpreter import PROVEN, InterpreterError, find_ros_python, private_environment


@click.group("ros", cls=Group)
def command() -> None:
    """Set up ROS 2 on a machine without it."""


@command.command()
def setup() -> None:
    """Install ROS 2's Python packages and test them."""
    try:
        set_up(echo)
    except KeyboardInterrupt:
        CommandError(f"interrupted: {AGAIN}").show()
        sys.exit(INTERRUPTED)


def set_up(say: Say) -> None:
    """Make the private environment, unless one exists that works, and prove that it carries a Twist.

    An environment that does not work, or whose setup was interrupted, is made again. Raises SetupError.
    """
    place, requirements = private_environment(), REQUIREMENTS.read_text(encoding="utf-8")
    python, marker = place / "bin" / "python", place / PROVEN
    if _is_made_of(requirements, marker):
        try:
            prove(python, say)
        except SetupError:
            say(f"The environment in {place} does not work: making it again.")
        else:
            say(f"ROS 2 is already set up in {place}.")
            _say_which_is_used(python, say)
            return
    if problem := unsuited():
        raise SetupError(problem)
    say("Installing ROS 2 Jazzy's Python packages from PyPI, each checked against its known hash,")
    say(f"into {place}: about {DOWNLOAD} MB to download, {SIZE} MB on disk.")
    try:
        make(place, say)
        prove(python, say)
        marker.write_text(requirements, encoding="utf-8")
    except BaseException:
        shutil.rmtree(place, ignore_errors=True)
        raise
    _say_which_is_used(python, say)


def _is_made_of(requirements: str, marker: Path) -> bool:
    with contextlib.suppress(OSError):
        return marker.read_text(encoding="utf-8") == requirements
    return False


def _say_which_is_used(python: Path, say: Say) -> None:
    """Say so if another Python is used for ROS 2."""
    try:
        found = find_ros_python(None)
    except InterpreterError as error:
        say(f"It is not used yet: {error}")
        return
    if found and found.python != str(python):
        say(f"It is not used yet: {found.origin} takes precedence, with {found.python}")
