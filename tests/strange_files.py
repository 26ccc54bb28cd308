"""Files that can't be read: all kinds of them, by the fixture `strange_file` in conftest.py."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class StrangeFile:
    """A function that makes a file of one kind in a folder, and the reason why it can't be read."""

    folder: Path
    kind: str

    @property
    def problem(self) -> str:
        return _KINDS[self.kind][1]

    def make(self, name: str) -> Path:
        path = self.folder / name
        _KINDS[self.kind][0](path)
        return path


def _make_sparse(path: Path) -> None:
    with path.open("wb") as file:
        file.truncate(2**40)


_KINDS: dict[str, tuple[Callable[[Path], object], str]] = {
    "link to nothing": (lambda path: path.symlink_to("nothing"), "it is a link to nothing"),
    "link to itself": (lambda path: path.symlink_to(path), "too many levels of symbolic links"),
    "pipe": (os.mkfifo, "it is not a regular file"),
    "endless device": (lambda path: path.symlink_to("/dev/zero"), "it is not a regular file"),
    "terminal": (lambda path: path.symlink_to("/dev/tty"), "it is not a regular file"),
    "folder": (Path.mkdir, "is a directory"),
    "terabyte": (_make_sparse, "it is larger than"),
    "unreadable": (lambda path: path.touch(0o000), "permission denied"),
}
KINDS = [kind for kind in _KINDS if kind != "unreadable" or os.geteuid()]  # root may read everything


def strange_files(folder: Path) -> Iterator[StrangeFile]:
    """Yield one of each kind, each in its own folder."""
    for kind in KINDS:
        own = folder / kind
        own.mkdir()
        yield StrangeFile(own, kind)
