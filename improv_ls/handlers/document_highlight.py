"""textDocument/documentHighlight."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide import references as finding
from improv_core.slices import in_slices
from improv_ls.documents import Document
from improv_ls.handlers.references import symbol_under
from improv_ls.session import Session
from improv_ls.to_lsp_locations import highlight


def document_highlight(
    ls: Session, document: Document, params: types.DocumentHighlightParams
) -> list[types.DocumentHighlight]:
    symbol = symbol_under(ls, document, params.position)
    found = finding.references(document.analysis, symbol) if symbol else ()
    return [highlight(document.lines, each, ls.editor.encoding) for each in in_slices(found)]
