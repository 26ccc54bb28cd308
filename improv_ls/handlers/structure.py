"""How a document is built: its outline, what folds, what a selection grows to; and the names of a whole workspace."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

from lsprotocol import types
from pygls.capabilities import get_capability
from pygls.uris import from_fs_path

from improv_core.ide.document_symbol import Entry, names_in, outline
from improv_core.ide.folding_range import folds
from improv_core.ide.selection_range import selections
from improv_core.text import LineIndex
from improv_ls import to_lsp_places as to_lsp
from improv_ls.documents import Document
from improv_ls.positions import Encoding, to_offset
from improv_ls.programs import looked_through, path_of, programs_in
from improv_ls.session import Session

MOST_SYMBOLS = 1_000


def document_symbol(
    ls: Session, params: types.DocumentSymbolParams
) -> list[types.DocumentSymbol] | list[types.SymbolInformation]:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return []
    entries, lines = outline(document.analysis), document.lines
    kind = "text_document.document_symbol.hierarchical_document_symbol_support"
    if get_capability(ls.client_capabilities, kind):
        return [to_lsp.document_symbol(lines, entry, ls.encoding) for entry in entries]
    flat = (part for entry in entries for part in entry.parts or (entry,))
    return [to_lsp.symbol(document.uri, lines, entry, ls.encoding) for entry in flat]


def workspace_symbols(
    documents: Sequence[Document],
    folders: Iterable[Path],
    query: str,
    encoding: Encoding,
    given_up: Callable[[], bool] = lambda: False,
) -> list[types.SymbolInformation]:
    """The names and robots that have the letters of the query in this order, of open documents first.

    Ends early once nobody wants to know any more.
    """
    found: list[types.SymbolInformation] = []
    for uri, lines, entries in _programs(documents, folders):
        if given_up():
            return found
        for entry in entries:
            if len(found) == MOST_SYMBOLS:
                return found
            if _fits(entry.name, query):
                found.append(to_lsp.symbol(uri, lines, entry, encoding))
    return found


def selection_range(ls: Session, params: types.SelectionRangeParams) -> list[types.SelectionRange] | None:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    offsets = (to_offset(document.lines, position, ls.encoding) for position in params.positions)
    spans = (selections(document.analysis, offset) for offset in offsets)
    return [to_lsp.selection_range(document.lines, each, ls.encoding) for each in spans]


def folding_range(ls: Session, params: types.FoldingRangeParams) -> list[types.FoldingRange]:
    document = ls.documents.get(params.text_document.uri)
    return [to_lsp.folding_range(fold) for fold in folds(document.analysis)] if document else []


def _programs(
    documents: Sequence[Document], folders: Iterable[Path]
) -> Iterator[tuple[str, LineIndex, Iterable[Entry]]]:
    """Open ones as they are in the editor, others as they are in their files."""
    for document in documents:
        yield document.uri, document.lines, names_in(document.analysis.text)
    opened = {path_of(document.uri) for document in documents}
    for path in programs_in(folders).paths:
        uri = from_fs_path(str(path))
        if uri and path not in opened:
            yield uri, *looked_through(path)


def _fits(name: str, query: str) -> bool:
    letters = iter(name.lower())
    return all(letter in letters for letter in query.lower())
