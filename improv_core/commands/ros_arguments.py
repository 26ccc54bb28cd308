"""ROS's own arguments on the command line: `improv play dance.improv --ros-args -r __node:=conductor`."""

from __future__ import annotations

from collections.abc import Sequence


def without_ros_arguments(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split a command line: return it without the arguments between each `--ros-args` and the next `--` or the end, and
    all of those."""
    ours, theirs = list[str](), list[str]()
    kept = ours
    for word in arguments:
        if word == "--ros-args":
            kept = theirs
        elif word == "--" and kept is theirs:
            kept = ours
        else:
            kept.append(word)
    return ours, theirs
