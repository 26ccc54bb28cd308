"""Programs for the tests of several commands."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    path = tmp_path / "broken.improv"
    path.write_bytes("\ufeffbeat 60\r\nr $ (forward 😀 foward\r\n".encode())
    return path
