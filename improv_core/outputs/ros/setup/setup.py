"""ROS 2's Python packages in an environment of their own, proven to carry a Twist. Standard library only."""

from __future__ import annotations

import contextlib
import shutil
from pathlib import Path

from improv_core.outputs.ros.setup.environment import DOWNLOAD, REQUIREMENTS, SIZE, Say, SetupError, make, unsuited
from improv_core.outputs.ros.setup.interpreter import PROVEN, InterpreterError, find_ros_python, private_environment
from improv_core.outputs.ros.setup.proof import Proof, prove


def set_up(say: Say, proof: Proof) -> None:
    """Make the private environment, unless one exists that works, and prove that it carries a Twist.

    An environment that doesn't work, or whose setup was interrupted, is made again. Raises SetupError.
    """
    place, requirements = private_environment(), REQUIREMENTS.read_text(encoding="utf-8")
    python, marker = place / "bin" / "python", place / PROVEN
    if _is_made_of(requirements, marker):
        try:
            prove(python, proof, say)
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
        prove(python, proof, say)
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
    """Report it if Improv uses another Python for ROS 2."""
    try:
        found = find_ros_python(None)
    except InterpreterError as error:
        say(f"It is not used yet: {error}")
        return
    if found and found.python != str(python):
        say(f"It is not used yet: {found.origin} takes precedence, with {found.python}")
