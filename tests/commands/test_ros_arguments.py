"""ROS's arguments on a command line, and those that name a node."""

from __future__ import annotations

import pytest

from improv_core.commands.ros_arguments import without_ros_arguments
from improv_core.outputs.ros.nodes import without_name


@pytest.mark.parametrize(
    ("line", "ours", "theirs"),
    [
        ("play a.improv", "play a.improv", ""),
        ("play a.improv --ros-args -r a:=b -p c:=1", "play a.improv", "-r a:=b -p c:=1"),
        ("play --ros-args -r a:=b -- a.improv", "play a.improv", "-r a:=b"),
        ("play --ros-args -r a:=b -- a.improv --ros-args -p c:=1", "play a.improv", "-r a:=b -p c:=1"),
        ("format -- a.improv", "format -- a.improv", ""),
        ("play a.improv --ros-args", "play a.improv", ""),
    ],
)
def test_the_arguments_of_ros(line: str, ours: str, theirs: str) -> None:
    assert without_ros_arguments(line.split()) == (ours.split(), theirs.split())


@pytest.mark.parametrize(
    ("arguments", "name", "kept"),
    [
        ("", None, ""),
        ("--ros-args -r a:=b", None, "--ros-args -r a:=b"),
        ("--ros-args -r a:=b -r __node:=conductor -p c:=1", "conductor", "--ros-args -r a:=b -p c:=1"),
        ("--ros-args --remap __name:=conductor", "conductor", "--ros-args"),
        ("--ros-args -r improv:__node:=conductor", "conductor", "--ros-args"),
        ("--ros-args -r __ns:=/lab", None, "--ros-args -r __ns:=/lab"),
    ],
)
def test_the_name_of_the_node(arguments: str, name: str | None, kept: str) -> None:
    assert without_name(arguments.split()) == (name, kept.split())
