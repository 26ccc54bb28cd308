"""Expands xacro files with the program `xacro`, in a process with limits: such a file can loop and grow for ever."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import tempfile
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from improv_core.commands.exit_codes import CommandError
from improv_core.ipc.child import Child, Policy
from improv_core.robots.urdf import LARGEST_URDF

LIMIT = 30.0
"""Seconds for one file."""
MAX_MEMORY = 2_000_000_000
"""Bytes of address space."""
NEAR = 4
"""The folders above a file in which the packages are that it may name, such as urdf/, a package, its repository, and a
workspace."""
INDEX = """import os

NEAR = {}

def get_package_share_directory(name):
    for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        share = os.path.join(prefix, "share", name)
        if os.path.exists(os.path.join(share, "package.xml")):
            return share
    if name in NEAR:
        return NEAR[name]
    raise LookupError("the package " + name + " is neither installed nor near the file")
"""
"""The module `ament_index_python.packages` for xacro. `$(find NAME)` asks it for a package's folder. The one from ROS
knows installed packages only, and xacro from PyPI comes without it."""


def is_xacro(source: bytes) -> bool:
    """Return whether a URDF still has to be expanded."""
    return re.search(rb"<xacro:|\$[({]", source) is not None


def find_xacro() -> str | None:
    """Return the path of the program, if it is installed in a folder that PATH names in full."""
    found = shutil.which("xacro")
    return found if found and Path(found).is_absolute() else None


def expand(program: str, file: Path) -> bytes:
    """Return the URDF that the program makes of a file, or its beginning if it is too large. Raises CommandError."""
    with tempfile.TemporaryDirectory() as folder:
        index = Path(folder, "ament_index_python", "packages.py")
        index.parent.mkdir()
        index.write_text(INDEX.replace("{}", repr(_packages_near(file.absolute())), 1), encoding="utf-8")
        path = os.pathsep.join(filter(None, [folder, os.environ.get("PYTHONPATH")]))
        return _expand(program, file, {**os.environ, "PYTHONPATH": path})


def _packages_near(file: Path) -> Mapping[str, str]:
    """The folders of the ROS packages around a file, by name."""
    found = dict[str, str]()
    for folder in [*file.parents][:NEAR]:
        for manifest in (folder / "package.xml", *sorted(folder.glob("*/package.xml"))):
            with suppress(OSError):
                name = re.search(r"<name>\s*([\w-]+)\s*</name>", manifest.read_text("utf-8", "replace"))
                found.setdefault(name[1] if name else manifest.parent.name, str(manifest.parent))
    return found


def _expand(program: str, file: Path, env: Mapping[str, str]) -> bytes:
    try:
        child = Child([program, str(file.absolute())], Policy(end=1.0, errors=subprocess.PIPE), env)
    except OSError as error:
        raise CommandError(f"{program} does not start: {error.strerror}") from None
    with suppress(ImportError, AttributeError, OSError):  # only Linux can limit another process
        import resource

        resource.prlimit(child.pid, resource.RLIMIT_AS, (MAX_MEMORY, MAX_MEMORY))
    child.close_input()
    made, end = bytearray(), time.monotonic() + LIMIT
    with suppress(EOFError):
        while len(made) <= LARGEST_URDF and (left := end - time.monotonic()) > 0:
            made += child.read_some(left)
        child.kill()
    code = child.wait()
    if len(made) > LARGEST_URDF or code == 0:
        return bytes(made)
    why = next((line for line in child.errors if line.startswith("error: ")), child.last_error or "it was killed")
    if time.monotonic() >= end:
        why = f"it took more than {LIMIT:g} s"
    argument = re.search(r"Undefined substitution argument (\w+)", why)
    command = f"xacro {file}{f' {argument[1]}:=VALUE' if argument else ''} > robot.urdf"
    raise CommandError(f"{file}: xacro can't expand it ({why}): run `{command}`, and read that")
