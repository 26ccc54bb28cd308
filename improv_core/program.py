"""Programs in files."""

from __future__ import annotations

from pathlib import Path


class ReadError(Exception):
    """A file can't be read as a program; one plain line that says why."""


def read_program(path: Path) -> str:
    """The text of a program. Raises ReadError."""
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        problem = "it is not UTF-8 text"
    except OSError as error:
        problem = (error.strerror or "it can't be read").lower()
    raise ReadError(f"{path}: {problem}")
