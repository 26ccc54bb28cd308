"""The package for a ROS 2 workspace. `ros2 launch` can't run here, so its file is read instead."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

from improv_core import __version__
from tests.test_architecture import MESSAGES_OF_ROS

FOLDER = Path(__file__).parents[2] / "editors" / "ros"
PACKAGE = ElementTree.parse(FOLDER / "package.xml").getroot()


def calls(path: Path, name: str) -> list[ast.Call]:
    """Return all calls of a function in a file."""
    nodes = ast.walk(ast.parse(path.read_text("utf-8")))
    return [node for node in nodes if isinstance(node, ast.Call) and ast.unparse(node.func) == name]


def test_the_manifest_agrees_with_the_package() -> None:
    assert PACKAGE.get("format") == "3"
    assert [PACKAGE.findtext(tag) for tag in ("name", "version", "license")] == ["improv", __version__, "MIT"]
    assert PACKAGE.findtext("export/build_type") == "ament_python"
    assert {"rclpy", *MESSAGES_OF_ROS} <= {element.text for element in PACKAGE.findall("exec_depend")}


def test_installed_files_exist_and_are_where_ros_looks() -> None:
    (setup,) = calls(FOLDER / "setup.py", "setup")
    named = {word.arg: ast.literal_eval(word.value) for word in setup.keywords}
    assert (named["name"], named["version"]) == ("improv", __version__)
    installed = {(folder, file) for folder, files in named["data_files"] for file in files}
    assert installed == {
        ("share/ament_index/resource_index/packages", "resource/improv"),
        ("share/improv", "package.xml"),
        ("share/improv/launch", "launch/dance.launch.py"),
        ("lib/improv", "scripts/improv"),
    }
    assert all((FOLDER / file).is_file() for _, file in installed)


def test_the_command_runs_the_one_on_the_path() -> None:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    command = [str(FOLDER / "scripts" / "improv"), "--version"]
    done = subprocess.run(command, env={**os.environ, "PATH": path}, capture_output=True, text=True, timeout=60)
    assert done.stdout == f"improv, version {__version__}\n"


def test_the_launch_file_starts_improv_with_its_arguments() -> None:
    launch = FOLDER / "launch" / "dance.launch.py"
    assert any(
        isinstance(node, ast.FunctionDef) and node.name == "generate_launch_description"
        for node in ast.parse(launch.read_text("utf-8")).body
    )
    declared = {ast.literal_eval(call.args[0]) for call in calls(launch, "DeclareLaunchArgument")}
    used = {ast.literal_eval(call.args[0]) for call in calls(launch, "LaunchConfiguration")}
    assert declared == used == {"file", "backend", "node", "namespace", "speed"}
    (node,) = calls(launch, "Node")
    named = {word.arg: word.value for word in node.keywords}
    assert [ast.literal_eval(named[key]) for key in ("package", "executable")] == ["improv", "improv"]
    # Without a namespace, launch passes `/`, or that of the group around it: an empty one can't be passed to ROS.
    assert [ast.unparse(named[key]) for key in ("name", "namespace")] == [
        "LaunchConfiguration('node')",
        "LaunchConfiguration('namespace')",
    ]
    arguments = named["arguments"]
    assert isinstance(arguments, ast.List)
    command, *options = [str(ast.literal_eval(word)) for word in arguments.elts if isinstance(word, ast.Constant)]
    asked = [sys.executable, "-m", "improv_core", command, "--help"]
    told = subprocess.run(asked, capture_output=True, text=True, check=True, timeout=60).stdout
    assert all(f"{option} " in told for option in options)
