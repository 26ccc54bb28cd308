"""Programs and `improv.toml` in files. Only regular files are opened, so reading never blocks and always ends.

A program may also come from standard input, `-`, or from a file that a shell has opened: `/dev/fd/63` for `<(…)`.
"""

from __future__ import annotations

import errno
import os
import stat
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from improv_core import LineError
from improv_core.diagnostics import Diagnostic
from improv_core.program.analysis import LONGEST_PROGRAM, Analysis, analyze
from improv_core.robots.config import FILE_NAME, Robots, absolute, find_robots_file, read_robots
from improv_core.score.score import LINK_PATIENCE, Host
from improv_core.text import Span

if TYPE_CHECKING:
    from improv_core.robots.skeletons import Skeleton

ENDING = ".improv"
"""The ending of the names of programs."""
STANDARD_INPUT = Path("-")
"""The path that stands for standard input. Its programs are for the robots of the current folder."""
LARGEST_ROBOTS_FILE = 1_000_000
"""The most bytes of an `improv.toml`."""
_OPENING = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


class ReadError(LineError):
    """A file can't be read as a program. The message is one line that says why."""


def analyze_file(path: Path) -> Analysis:
    """Return the program in a file, for the robots of the nearest `improv.toml`. Raises ReadError."""
    return analyze(read_program(path), robots_near(path.parent))


def robots_near(folder: Path) -> Robots:
    """Return the robots of the nearest `improv.toml` in a folder or its parents. Raises ReadError if it is
    unreadable."""
    found = find_robots_file(folder)
    return robots_in(found) if found else Robots()


def robots_in(path: Path) -> Robots:
    """Return the robots of an `improv.toml`. Raises ReadError.

    An empty one can't be read: somebody may just be writing it, and without its limits, robots could move too fast.
    """
    text = read_robots_file(path)
    if not text.strip():
        raise ReadError(f"{path}: it is empty: describe robots in it, or delete it")
    return robots_from(text, path)


def read_robots_file(path: Path) -> str:
    """Return the text of an `improv.toml`. Raises ReadError."""
    return _read(path, LARGEST_ROBOTS_FILE)


def robots_from(text: str, path: Path | None) -> Robots:
    """Return the robots in the text of an `improv.toml`, with the bodies in the URDFs that it names. Never raises."""
    robots = read_robots(text, path)
    if not robots.urdfs:
        return robots
    from improv_core.robots.skeletons import skeleton_in, with_skeletons  # rarely needed; XML is slow to import

    return with_skeletons(robots, _bytes_or_problem, _read_urdf or skeleton_in)


_read_urdf: Callable[[bytes], Skeleton | str] | None = None


def read_urdfs_by(read: Callable[[bytes], Skeleton | str] | None) -> None:
    """Set the function that reads URDFs; None for `skeleton_in`. The language server must not wait for one."""
    global _read_urdf
    _read_urdf = read


def robots_or_problem(folder: Path) -> Robots:
    """Do the same, but treat an unreadable file as one with an error: robots of an unknown kind must not move as if
    they were of another kind."""
    try:
        return robots_near(folder)
    except ReadError as error:
        return Robots(path=find_robots_file(folder), diagnostics=(Diagnostic("robots", Span(0, 0), str(error)),))


class PlayedRobots:
    """The `improv.toml` files of the programs that have played. Once one is gone, its robots have no limits and no
    emergency stop, and somebody may just be writing it: the first program is refused, and the next one plays."""

    def __init__(self) -> None:
        self._files: set[Path] = set()

    def check(self, program: Path, robots: Robots) -> None:
        """Note the robots of a program that is about to play. Raises ReadError if their `improv.toml` is gone."""
        nearest = len(robots.path.parts) if robots.path else 0
        folders = absolute(program).parents
        gone = {each for each in self._files if each.parent in folders and len(each.parts) > nearest}
        self._files -= gone
        if gone:
            raise ReadError(f"{max(gone, key=str)} is gone: save again to play without its limits")
        if robots.path:
            self._files.add(robots.path)


def outputs_near(folder: Path) -> frozenset[Host]:
    """Return the outputs of the robots that the `improv.toml` of a folder lists."""
    hosts = (each.host for each in robots_or_problem(folder).robots.values())
    return frozenset(replace(each, patience=LINK_PATIENCE) for each in hosts if each and each.output)


def read_program(path: Path) -> str:
    """Return the text of a program. Raises ReadError."""
    refuse_robots_file(path)
    return _read(path, LONGEST_PROGRAM)


def refuse_robots_file(path: Path) -> None:
    """Raise ReadError for an `improv.toml` in place of a program."""
    if path.name == FILE_NAME:
        raise ReadError(f"{path}: it describes robots: name a program instead, such as dance{ENDING}")


def read_bytes(path: Path, most: int = LONGEST_PROGRAM) -> bytes:
    """Return the content of a regular file of at most `most` bytes. Raises ReadError."""
    try:
        data = sys.stdin.buffer.read(most + 1) if path == STANDARD_INPUT and sys.stdin else _read_bytes(path, most + 1)
        if len(data) > most:
            raise ReadError(f"{path}: it is larger than {most // 1_000_000} MB")
        return data
    except FileNotFoundError:
        problem = "it is a link to nothing" if path.is_symlink() else "no such file or directory"
        if meant := without_ending(path):
            problem += f": did you mean {meant}?"
    except (OSError, ValueError) as error:  # ValueError: a path with a zero byte
        problem = (getattr(error, "strerror", None) or "it can't be read").lower()
    raise ReadError(f"{path}: {problem}")


def without_ending(path: Path) -> Path | None:
    """Return the program that a path without the ending probably means."""
    program = path.parent / f"{path.name}{ENDING}"
    return program if program.is_file() and not path.exists() else None


def _read_bytes(path: Path, most: int) -> bytes:
    opened = path == Path("/dev/stdin") or path.parent == Path("/dev/fd")
    if not opened:
        _refuse_others(path.stat())  # before it is opened: opening a device may do something
    with os.fdopen(os.open(path, os.O_RDONLY if opened else _OPENING), "rb") as file:
        if not opened:
            _refuse_others(os.fstat(file.fileno()))  # it may have been replaced
        return file.read(most)


def _bytes_or_problem(path: Path, most: int) -> bytes | str:
    try:
        return read_bytes(path, most)
    except ReadError as error:
        return str(error).removeprefix(f"{path}: ")


def _read(path: Path, most: int) -> str:
    """Return the text of a regular file of at most `most` bytes. Raises ReadError."""
    try:
        return read_bytes(path, most).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise ReadError(f"{path}: it is not UTF-8 text") from None


def _refuse_others(found: os.stat_result) -> None:
    """Raise OSError unless this is a regular file: a pipe or a device may never end."""
    if stat.S_ISDIR(found.st_mode):
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR))
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "it is not a regular file")
