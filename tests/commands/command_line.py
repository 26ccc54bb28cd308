"""The command line, run as people run it."""

from __future__ import annotations

import os
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


def run(*arguments: str | Path, env: dict[str, str] | None = None) -> subprocess.CompletedProcess[str]:
    command = [*IMPROV, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, env={**os.environ, **(env or {})})
