"""The open documents: programs with their analyses, and `improv.toml` files, each as the editor has it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TypeAlias
from urllib.parse import unquote, urlsplit

from lsprotocol import types
from pygls.uris import from_fs_path, to_fs_path

from improv_core.program.analysis import Analysis, unread
from improv_core.program.files import ReadError, read_robots_file, robots_or_problem
from improv_core.robots.config import FILE_NAME, Robots
from improv_core.text import LineIndex, difference
from improv_ls.positions import Encoding, to_span


@dataclass(frozen=True, slots=True)
class Document:
    """One version of an open program."""

    uri: str
    version: int | None
    analysis: Analysis

    @property
    def lines(self) -> LineIndex:
        return self.analysis.lines


@dataclass(frozen=True, slots=True)
class RobotsFile:
    """One version of an open `improv.toml`."""

    uri: str
    version: int | None
    lines: LineIndex


AnyDocument: TypeAlias = Document | RobotsFile


def is_program(uri: str, language_id: str) -> bool:
    """Return whether an editor has opened a program: by its language, or by its name if the editor knows no
    `improv`."""
    name = name_of(uri)
    return name != FILE_NAME and (language_id == "improv" or name.endswith(".improv"))


def is_robots_file(uri: str) -> bool:
    return name_of(uri) == FILE_NAME


def path_of(uri: str) -> Path | None:
    """Return the file of a document; None if it was never saved, or is on another machine."""
    path = to_fs_path(uri) if uri.startswith("file:") else None
    return Path(path) if path else None


def opened(uri: str, version: int | None, text: str) -> Document:
    """Open a new document, all of which waits to be brought up to date."""
    return Document(uri, version, unread(text, robots_of(uri)))


def robots_of(uri: str) -> Robots:
    """Read the `improv.toml` near a document; no robots if the document is not a file, or there is none."""
    path = path_of(uri)
    return robots_or_problem(path.parent) if path else Robots()


def on_disk(robots: Robots) -> RobotsFile | None:
    """Return the `improv.toml` that these robots were read from; None if there is none."""
    uri = from_fs_path(str(robots.path)) if robots.path else None
    return RobotsFile(uri, None, LineIndex(robots.text)) if uri else None


def robots_file_now(path: Path, opened: Mapping[str, RobotsFile]) -> RobotsFile | None:
    """Return the `improv.toml` for an edit: the editor's or, if it isn't open there, the one on disk now, since another
    program may just have written it. Empty if there is none, and None if it can't be read."""
    uri = from_fs_path(str(path)) or ""
    try:
        return opened.get(uri) or RobotsFile(uri, None, LineIndex(read_robots_file(path) if path.exists() else ""))
    except ReadError:
        return None


def moved(uri: str, old: str, new: str) -> str:
    """Return the URI of a document after its file, or a folder around it, has been renamed."""
    rest = uri.removeprefix(old)
    return new + rest if rest != uri and rest[:1] in ("", "/") else uri


def changed(
    document: Document,
    version: int | None,
    changes: Sequence[types.TextDocumentContentChangeEvent],
    encoding: Encoding,
) -> Document:
    """Apply the editor's changes to the document, each to the result of the one before.

    The statements that they touch wait to be brought up to date.
    """
    analysis = document.analysis
    for change in changes:
        if isinstance(change, types.TextDocumentContentChangePartial):
            start, end = to_span(analysis.lines, change.range, encoding)
            analysis = analysis.touched(start, end, change.text)
        else:
            analysis = analysis.touched(*difference(analysis.text, change.text))  # the rest keeps its analysis
    return Document(document.uri, version, analysis)


def changed_file(
    file: RobotsFile, version: int | None, changes: Iterable[types.TextDocumentContentChangeEvent], encoding: Encoding
) -> RobotsFile:
    """Apply the editor's changes to the `improv.toml`, each to the result of the one before."""
    lines = file.lines
    for change in changes:
        text = change.text
        if isinstance(change, types.TextDocumentContentChangePartial):
            start, end = to_span(lines, change.range, encoding)
            text = lines.text[:start] + text + lines.text[end:]
        lines = LineIndex(text)
    return RobotsFile(file.uri, version, lines)


def name_of(uri: str) -> str:
    """Return the name of a document's file."""
    return PurePosixPath(unquote(urlsplit(uri).path)).name
