"""Expands xacro files with the program `xacro`, in a process with limits: such a file can loop and grow for ever."""

from __future__ import annotations

import re
import shutil
import subprocess
import time
from contextlib import suppress
from pathlib import Path

from improv_core.commands.exit_codes import CommandError
from improv_core.ipc.child import Child, Policy
from improv_core.robots.urdf import LARGEST_URDF

LIMIT = 30.0
"""Seconds for one file."""
MOST_MEMORY = 2_000_000_000
"""Bytes of address space."""


def is_xacro(source: bytes) -> bool:
    """Return whether a URDF still has to be expanded."""
    return re.search(rb"<xacro:|\$[({]", source) is not None


def find_xacro() -> str | None:
    """Return the path of the program, if it is installed in a folder that PATH names in full."""
    found = shutil.which("xacro")
    return found if found and Path(found).is_absolute() else None


def expand(program: str, file: Path) -> bytes:
    """Return the URDF that the program makes of a file, or its beginning if it is too large. Raises CommandError."""
    try:
        child = Child([program, str(file.absolute())], Policy(end=1.0, errors=subprocess.PIPE))
    except OSError as error:
        raise CommandError(f"{program} does not start: {error.strerror}") from None
    with suppress(ImportError, AttributeError, OSError):  # only Linux can limit another process
        import resource

        resource.prlimit(child.pid, resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
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
    raise CommandError(f"{file}: xacro can't expand it ({why}): run `xacro {file} > robot.urdf`, and read that")
