"""ROS's own arguments on the command line: `improv play dance.improv --ros-args -r __node:=conductor`."""

from __future__ import annotations

import sys
from collections.abc import Sequence

import click

ROS_ARGS = "--ros-args"


def is_launched() -> bool:
    """Return whether `ros2 launch` has started this command: with ROS's arguments, and no terminal to type in. Its
    output may look like a terminal."""
    context = click.get_current_context(silent=True)
    return bool(context and context.obj) and not (sys.stdin and sys.stdin.isatty())


def without_ros_arguments(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split a command line: return it without the arguments between each `--ros-args` and the next `--` or the end, and
    all of those, after one `--ros-args`."""
    ours, theirs = list[str](), list[str]()
    kept = ours
    for word in arguments:
        if word == ROS_ARGS:
            kept = theirs
            theirs[:1] = [ROS_ARGS]
        elif word == "--" and kept is theirs:
            kept = ours
        else:
            kept.append(word)
    return ours, theirs
