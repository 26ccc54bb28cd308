"""workspace/symbol."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from lsprotocol import types
from pygls.uris import from_fs_path

from improv_core.ide.document_symbol import OutlineEntry, names_in
from improv_core.text import LineIndex, has_in_order
from improv_ls.documents import Document, path_of
from improv_ls.positions import Encoding
from improv_ls.programs import names_in_file, programs_in
from improv_ls.session import Session
from improv_ls.to_lsp_locations import symbol_information

MAX_SYMBOLS = 1_000


async def workspace_symbol(ls: Session, params: types.WorkspaceSymbolParams) -> list[types.SymbolInformation]:
    """Search for symbols on a thread, so that typing continues while it reads files."""
    documents, editor = list(ls.documents.values()), ls.editor
    cancelled = threading.Event()
    try:
        return await asyncio.to_thread(
            search, documents, editor.folders, params.query, editor.encoding, cancelled.is_set
        )
    finally:
        cancelled.set()


def search(
    documents: Sequence[Document],
    folders: Iterable[Path],
    query: str,
    encoding: Encoding,
    is_cancelled: Callable[[], bool] = lambda: False,
) -> list[types.SymbolInformation]:
    """Find the names and robots that contain the letters of the query in this order, those of open documents first.

    Ends early once the request is canceled.
    """
    found: list[types.SymbolInformation] = []
    for uri, lines, entries in _programs(documents, folders):
        if is_cancelled():
            return found
        for entry in entries:
            if len(found) == MAX_SYMBOLS:
                return found
            if has_in_order(entry.name.lower(), query.lower()):
                found.append(symbol_information(uri, lines, entry, encoding))
    return found


def _programs(
    documents: Sequence[Document], folders: Iterable[Path]
) -> Iterator[tuple[str, LineIndex, Iterable[OutlineEntry]]]:
    """Yield open programs as in the editor, others as in their files."""
    for document in documents:
        yield document.uri, document.lines, names_in(document.analysis.text)
    opened = {path_of(document.uri) for document in documents}
    for path in programs_in(folders).paths:
        uri = from_fs_path(str(path))
        if uri and path not in opened:
            yield uri, *names_in_file(path)
