"""The programs that share one `improv.toml`, open or not."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

from pygls.uris import from_fs_path

from improv_core.ide.rename import RefusalError
from improv_core.program.analysis import analyze
from improv_core.program.files import ReadError, read_program
from improv_core.robots.config import find_robots_file
from improv_ls.documents import Document, path_of
from improv_ls.programs import programs_in


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


def _closed(path: Path, word: str) -> Document | None:
    uri = from_fs_path(str(path))
    try:
        text = read_program(path)
    except ReadError:
        return None
    return Document(uri, None, analyze(text)) if uri and word in text else None
