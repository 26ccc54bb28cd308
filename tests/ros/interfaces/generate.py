"""Generate the sources of message types with ROS's own generators: `python generate.py ROS DEFINITIONS FOLDER`."""

from __future__ import annotations

import sys
from importlib import metadata
from pathlib import Path

from rosidl_cli import entry_points

# The wheels list each generator twice, which the original refuses.
entry_points.get_entry_points = lambda group, **_: {each.name: each for each in metadata.entry_points(group=group)}

from rosidl_cli.command.generate.api import generate  # noqa: E402

ros, definitions, folder = (Path(each).resolve() for each in sys.argv[1:])
generate(
    package_name=definitions.name,
    interface_files=[f"{definitions}:{path.relative_to(definitions)}" for path in definitions.rglob("*.idl")],
    include_paths=[str(ros / "share")],
    output_path=folder,
    types=["c", "py"],
    typesupports=["c", "fastrtps_c", "introspection_c"],
)
