"""ROS's arguments on a command line, and those that name a node."""

from __future__ import annotations

import subprocess
import sys

import pytest

from improv_core.commands.ros_arguments import without_ros_arguments
from improv_core.outputs.ros.nodes import is_harmless, node_name, without_name


@pytest.mark.parametrize(
    ("line", "ours", "theirs"),
    [
        ("play a.improv", "play a.improv", ""),
        ("play a.improv --ros-args -r a:=b -p c:=1", "play a.improv", "--ros-args -r a:=b -p c:=1"),
        ("play --ros-args -r a:=b -- a.improv", "play a.improv", "--ros-args -r a:=b"),
        ("play --ros-args -r a:=b -- a.improv --ros-args -p c:=1", "play a.improv", "--ros-args -r a:=b -p c:=1"),
        ("format -- a.improv", "format -- a.improv", ""),
        ("play a.improv --ros-args", "play a.improv", "--ros-args"),
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


@pytest.mark.parametrize("namespace", ["", "/lab", "/lab/two"])
def test_a_standby_and_the_node_of_a_living_stage_are_told_apart_in_each_namespace(namespace: str) -> None:
    stage = f"{namespace}/{node_name()}"
    assert (is_harmless(f"{stage}_standby"), is_harmless(f"{stage}_standby_2"), is_harmless(stage)) == (
        True,
        True,
        False,
    )
    assert not is_harmless(f"{namespace}/teleop")


@pytest.mark.parametrize("namespace", ["", "/lab"])
def test_the_node_of_a_stage_that_was_killed_is_harmless(namespace: str) -> None:
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    assert is_harmless(f"{namespace}/{node_name(ended.pid)}")
