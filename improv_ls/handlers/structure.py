"""textDocument/documentSymbol, foldingRange, and selectionRange."""

from __future__ import annotations

from functools import partial

from lsprotocol import types

from improv_core.ide.document_symbol import flattened, outline
from improv_core.ide.folding_range import folds
from improv_core.ide.robots_file import structure as robots_file
from improv_core.ide.selection_range import selections
from improv_core.slices import in_slices
from improv_ls import to_lsp_locations as to_lsp
from improv_ls.documents import AnyDocument, RobotsFile
from improv_ls.positions import to_offset
from improv_ls.session import Session


def document_symbol(
    ls: Session, document: AnyDocument, params: types.DocumentSymbolParams
) -> list[types.DocumentSymbol] | list[types.SymbolInformation]:
    lines, encoding = document.lines, ls.editor.encoding
    if isinstance(document, RobotsFile):
        entries, flat = robots_file.outline(lines.text), robots_file.flattened
    else:
        entries, flat = outline(document.analysis), flattened
    if ls.editor.can("text_document.document_symbol.hierarchical_document_symbol_support"):
        return [to_lsp.document_symbol(lines, entry, encoding) for entry in in_slices(entries)]
    return [to_lsp.symbol_information(document.uri, lines, entry, encoding) for entry in in_slices(flat(entries))]


def folding_range(ls: Session, document: AnyDocument, params: types.FoldingRangeParams) -> list[types.FoldingRange]:
    found = robots_file.folds(document.lines) if isinstance(document, RobotsFile) else folds(document.analysis)
    return [*map(to_lsp.folding_range, found)]


def selection_range(
    ls: Session, document: AnyDocument, params: types.SelectionRangeParams
) -> list[types.SelectionRange]:
    lines, encoding = document.lines, ls.editor.encoding
    if isinstance(document, RobotsFile):
        around = partial(robots_file.selections, lines.text)
    else:
        around = partial(selections, document.analysis)
    spans = (around(to_offset(lines, position, encoding)) for position in params.positions)
    return [to_lsp.selection_range(lines, each, encoding) for each in spans]
