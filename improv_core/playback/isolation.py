"""How to start a Python so that it imports nothing from the current folder. Standard library only."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TypedDict


class Surroundings(TypedDict):
    """What `subprocess` takes: the environment, and the working directory."""

    env: dict[str, str]
    cwd: str


def isolated(env: Mapping[str, str]) -> Surroundings:
    """The root folder, and this environment without the entries of PYTHONPATH that are empty or relative.

    Python's option `-I` ignores all of PYTHONPATH, but without its other entries Python can't find a sourced ROS.
    """
    absolute = [entry for entry in env.get("PYTHONPATH", "").split(os.pathsep) if Path(entry).is_absolute()]
    others = {name: value for name, value in env.items() if name != "PYTHONPATH"}
    return {"env": others | ({"PYTHONPATH": os.pathsep.join(absolute)} if absolute else {}), "cwd": _ROOT}


_ROOT = Path(sys.executable).anchor  # contains no modules, and only administrators can add some
