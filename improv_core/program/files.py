"""Programs and `improv.toml` in files. Only regular files are opened, so reading never blocks and always ends.

A program may also come from what a shell has opened: `/dev/stdin`, or `/dev/fd/63` for `<(…)`.
"""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from improv_core.program.analysis import LONGEST_PROGRAM, Analysis, analyze
from improv_core.robots.config import Robots, find_robots_file, read_robots

LARGEST_ROBOTS_FILE = 1_000_000
"""Bytes of an `improv.toml`."""
_OPENING = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


class ReadError(Exception):
    """A file can't be read as a program. The message is one line that says why."""


def analyze_file(path: Path) -> Analysis:
    """The program in a file, for the robots of the nearest `improv.toml`. Raises ReadError."""
    return analyze(read_program(path), robots_near(path.parent))


def robots_near(folder: Path) -> Robots:
    """The robots of the nearest `improv.toml` in a folder or its parents. Raises ReadError if it can't be read."""
    found = find_robots_file(folder)
    return read_robots(_read(found, LARGEST_ROBOTS_FILE), found) if found else Robots()


def read_program(path: Path) -> str:
    """The text of a program. Raises ReadError."""
    return _read(path, LONGEST_PROGRAM)


def read_bytes(path: Path, most: int = LONGEST_PROGRAM) -> bytes:
    """What a regular file holds, at most so many bytes. Raises ReadError."""
    try:
        opened = path == Path("/dev/stdin") or path.parent == Path("/dev/fd")
        if not opened:
            _refuse_others(path.stat())  # before it is opened: opening a device may do something
        with os.fdopen(os.open(path, os.O_RDONLY if opened else _OPENING), "rb") as file:
            if not opened:
                _refuse_others(os.fstat(file.fileno()))  # it may have been replaced
            data = file.read(most + 1)
        if len(data) > most:
            raise ReadError(f"{path}: it is larger than {most // 1_000_000} MB")
        return data
    except FileNotFoundError:
        problem = "it is a link to nothing" if path.is_symlink() else "no such file or directory"
    except (OSError, ValueError) as error:  # ValueError: a path with a zero byte
        problem = (getattr(error, "strerror", None) or "it can't be read").lower()
    raise ReadError(f"{path}: {problem}")


def _read(path: Path, most: int) -> str:
    """The text of a regular file of at most so many bytes. Raises ReadError."""
    try:
        return read_bytes(path, most).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ReadError(f"{path}: it is not UTF-8 text") from None


def _refuse_others(found: os.stat_result) -> None:
    """Raise OSError unless this is a regular file: a pipe may never end, and a device even less."""
    if stat.S_ISDIR(found.st_mode):
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "it is not a regular file")
