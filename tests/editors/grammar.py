"""The tree-sitter grammar, compiled as a person compiles it."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Mapping
from pathlib import Path

from tests.editors.editors import ROOT, find
from tests.needs import need


def tool() -> str:
    """Return the path of tree-sitter's command line."""
    return find("TREE_SITTER", "tree-sitter/usr/bin/tree-sitter")


def run(commands: str, env: Mapping[str, str]) -> None:
    """Run commands from a page of instructions in the repository; this environment adds to the process's own."""
    need("node"), need("cc")
    path = f"{Path(tool()).parent}:{os.environ['PATH']}"
    done = subprocess.run(
        ["sh", "-euc", commands],
        cwd=ROOT,
        env={**os.environ, "PATH": path, **env},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr
