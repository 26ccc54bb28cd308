"""The command line, run as people run it."""

from __future__ import annotations

import os
import pty
import subprocess
import sys
from pathlib import Path

IMPROV = [sys.executable, "-u", "-m", "improv_core"]
LIMIT = 60.0
"""Seconds to wait for anything on a busy machine."""
EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.improv"))
REACTING = sorted((Path(__file__).parents[2] / "examples" / "senses").glob("*.improv"))
"""Examples in which robots react."""
SQUARE = next(path for path in EXAMPLES if path.name == "square.improv")


def run(
    *arguments: str | Path, env: dict[str, str] | None = None, text: str = "", folder: Path | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a command with this text as standard input."""
    command, environment = [*IMPROV, *map(str, arguments)], {**os.environ, **(env or {})}
    return subprocess.run(
        command, input=text, capture_output=True, encoding="utf-8", timeout=LIMIT, env=environment, cwd=folder
    )


def shown_in_terminal(*arguments: str | Path) -> str:
    """What a terminal gets from a command."""
    ours, theirs = pty.openpty()
    process = subprocess.Popen([*IMPROV, *map(str, arguments)], stdout=theirs, stderr=theirs)
    os.close(theirs)
    shown = b""
    try:
        while data := os.read(ours, 65_536):
            shown += data
    except OSError:  # Linux reports the end like this
        pass
    os.close(ours)
    process.wait(LIMIT)
    return shown.decode("utf-8")
