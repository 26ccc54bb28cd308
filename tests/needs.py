"""Programs that a test needs on the machine."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from typing import NoReturn

import pytest

EXTENSION = Path(__file__).parents[1] / "editors" / "vscode"


def need(program: str) -> str:
    """Return the path of the program, or skip the test (fail under IMPROV_REQUIRE_ALL=1)."""
    path = shutil.which(program)
    if path is None:
        lacking(f"{program} is not installed")
    return path


def need_headless_chromium() -> str:
    """Return the path of Debian's Chromium without windows, which needs less CPU, or of Chromium, or skip the test."""
    return shutil.which("chromium-headless-shell") or need("chromium")


def need_extension() -> Path:
    """Return the folder of VS Code's extension, with the modules from npm, or skip the test."""
    need("node")
    if not (EXTENSION / "node_modules" / ".package-lock.json").exists():  # npm writes this file last
        lacking("VS Code's extension has no modules: npm ci --prefix editors/vscode")
    return EXTENSION


def lacking(reason: str) -> NoReturn:
    """Skip the test with the reason (fail under IMPROV_REQUIRE_ALL=1)."""
    if os.environ.get("IMPROV_REQUIRE_ALL") == "1":
        pytest.fail(reason)
    pytest.skip(reason)
