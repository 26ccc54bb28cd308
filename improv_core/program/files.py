"""Reads programs from files."""

from __future__ import annotations

from pathlib import Path

from improv_core.program.analysis import Analysis, analyze
from improv_core.robots.config import Robots, find_robots_file, read_robots


class ReadError(Exception):
    """A file can't be read as a program. The message is one line that says why."""


def analyze_file(path: Path) -> Analysis:
    """The program in a file, for the robots of the nearest `improv.toml`. Raises ReadError."""
    return analyze(read_program(path), robots_near(path.parent))


def robots_near(folder: Path) -> Robots:
    """The robots of the nearest `improv.toml` in a folder or its parents. Raises ReadError if it can't be read."""
    found = find_robots_file(folder)
    return read_robots(read_program(found), found) if found else Robots()


def read_program(path: Path) -> str:
    """The text of a program. Raises ReadError."""
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        problem = "it is not UTF-8 text"
    except OSError as error:
        problem = (error.strerror or "it can't be read").lower()
    raise ReadError(f"{path}: {problem}")
