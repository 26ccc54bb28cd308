"""An `improv.toml`, with the diagnostics drawn under it."""

from __future__ import annotations

from improv_core.robots.config import Robots, read_robots
from improv_core.text import LineIndex
from tests.program.drawing import carets, undrawn


def check(expected: str) -> Robots:
    """Read the lines without carets; the diagnostics drawn under them must be the lines with carets."""
    expected, text = undrawn(expected)
    found = read_robots(text)
    assert carets(LineIndex(text), found.diagnostics) == expected
    assert found.ok == (not found.diagnostics)
    return found
