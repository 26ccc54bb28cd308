"""The programs in folders, open or not, and those of one `improv.toml`: as many as can be read without a delay."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from pygls.uris import from_fs_path

from improv_core.ide.document_symbol import OutlineEntry, names_in
from improv_core.ide.rename import RefusalError
from improv_core.program.analysis import analyze
from improv_core.program.files import ReadError, read_program
from improv_core.robots.config import find_robots_file
from improv_core.text import LineIndex
from improv_ls.documents import Document, path_of

MAX_FILES = 1_000
MAX_ENTRIES = 20_000
"""Files and folders visited to find programs."""
LARGEST_FILE = 200_000
"""Bytes; larger files are not read."""
_SKIPPED = ("node_modules", "__pycache__")


@dataclass(frozen=True, slots=True)
class FoundPrograms:
    """Programs in folders; not `complete` if there may be more."""

    paths: list[Path]
    complete: bool


def programs_in(folders: Iterable[Path]) -> FoundPrograms:
    """Find the programs in folders and their subfolders, except hidden ones and links to folders."""
    paths: dict[Path, None] = {}
    for seen, entry in enumerate(_entries(folders)):
        if seen == MAX_ENTRIES or len(paths) == MAX_FILES:
            return FoundPrograms(list(paths), False)
        if entry.name.endswith(".improv") and entry.is_file():
            paths[Path(entry.path)] = None
    return FoundPrograms(list(paths), True)


def programs_for(documents: Mapping[str, Document], robots: Path | None, word: str) -> Iterator[Document]:
    """Yield the programs for the robots of a file that contain a word: open ones as in the editor, others as in their
    files.

    Raises RefusalError if there are too many files to find all of them.
    """
    if robots is None:
        return
    found = programs_in([robots.parent])
    if not found.complete:
        raise RefusalError(
            "rename it by hand: there are too many files near improv.toml to find all programs that use it"
        )
    opened = {path: document for document in documents.values() if (path := path_of(document.uri))}
    for path in dict.fromkeys([*opened, *found.paths]):
        if find_robots_file(path.parent) == robots:
            document = opened[path] if path in opened else _closed(path, word)
            if document and word in document.analysis.text:
                yield document


def names_in_file(path: Path) -> tuple[LineIndex, tuple[OutlineEntry, ...]]:
    """Return the names and robots in a file, read again if it has changed; none if it cannot be read or is too
    large."""
    try:
        state = path.stat()
    except OSError:
        return LineIndex(""), ()
    return _names(path, state.st_mtime_ns, state.st_size)


@lru_cache(maxsize=MAX_FILES)
def _names(path: Path, changed: int, size: int) -> tuple[LineIndex, tuple[OutlineEntry, ...]]:
    try:
        text = read_program(path) if size <= LARGEST_FILE else ""
    except ReadError:
        text = ""
    return LineIndex(text), tuple(names_in(text))


def _entries(folders: Iterable[Path]) -> Iterator[os.DirEntry[str]]:
    """Yield all entries of folders, breadth first."""
    waiting = deque(str(folder) for folder in folders)
    while waiting:
        try:
            with os.scandir(waiting.popleft()) as entries:
                for entry in sorted(entries, key=lambda entry: entry.name):
                    yield entry
                    hidden = entry.name.startswith(".") or entry.name in _SKIPPED
                    if not hidden and entry.is_dir(follow_symlinks=False):
                        waiting.append(entry.path)
        except OSError:  # a folder that we may not read
            continue


def _closed(path: Path, word: str) -> Document | None:
    uri = from_fs_path(str(path))
    try:
        text = read_program(path)
    except ReadError:
        return None
    return Document(uri, None, analyze(text)) if uri and word in text else None
