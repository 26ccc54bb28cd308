"""What a test needs of the machine."""

from __future__ import annotations

import os
import shutil
from typing import NoReturn

import pytest


def need(program: str) -> str:
    """Path of the program, or skip the test (fail under IMPROV_REQUIRE_ALL=1)."""
    path = shutil.which(program)
    if path is None:
        lacking(f"{program} is not installed")
    return path


def lacking(reason: str) -> NoReturn:
    """Skip the test, saying what the machine lacks (fail under IMPROV_REQUIRE_ALL=1)."""
    if os.environ.get("IMPROV_REQUIRE_ALL") == "1":
        pytest.fail(reason)
    pytest.skip(reason)
