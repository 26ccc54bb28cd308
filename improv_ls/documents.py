"""The open documents: their text as the editor has it, and its analysis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from lsprotocol import types
from pygls.uris import to_fs_path

from improv_core.diagnostics import Diagnostic
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.files import ReadError, robots_near
from improv_core.robots.config import Robots, find_robots_file
from improv_core.text import LineIndex, Span, difference
from improv_ls.positions import Encoding, to_span


@dataclass(frozen=True, slots=True)
class Document:
    """One version of an open document."""

    uri: str
    version: int | None
    analysis: Analysis

    @property
    def lines(self) -> LineIndex:
        return self.analysis.lines


def opened(uri: str, version: int | None, text: str) -> Document:
    return Document(uri, version, analyze(text, robots_of(uri)))


def robots_of(uri: str) -> Robots:
    """What the `improv.toml` near a document says; nothing if the document is not a file, or there is none.

    In one that can't be read all is wrong: robots that are not known must not move as if they were of any kind.
    """
    path = to_fs_path(uri) if uri.startswith("file:") else None
    if not path:
        return Robots()
    folder = Path(path).parent
    try:
        return robots_near(folder)
    except ReadError as error:
        return Robots(path=find_robots_file(folder), diagnostics=(Diagnostic("robots", Span(0, 0), str(error)),))


def moved(uri: str, old: str, new: str) -> str:
    """Where a document is once its file, or a folder around it, has another name."""
    rest = uri.removeprefix(old)
    return new + rest if rest != uri and rest[:1] in ("", "/") else uri


def changed(
    document: Document,
    version: int | None,
    changes: Sequence[types.TextDocumentContentChangeEvent],
    encoding: Encoding,
) -> Document:
    """The document after the editor's changes, each of which applies to the text the one before has left."""
    analysis = document.analysis
    for change in changes:
        if isinstance(change, types.TextDocumentContentChangePartial):
            start, end = to_span(analysis.lines, change.range, encoding)
            analysis = analysis.edited(start, end, change.text)
        else:
            analysis = analysis.edited(*difference(analysis.text, change.text))  # what is as it was keeps its place
    return Document(document.uri, version, analysis)
