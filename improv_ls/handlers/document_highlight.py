"""textDocument/documentHighlight."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide import references as finding
from improv_ls.handlers import robots_file
from improv_ls.handlers.references import symbol_under
from improv_ls.session import Session
from improv_ls.to_lsp_locations import highlight


def document_highlight(ls: Session, params: types.DocumentHighlightParams) -> list[types.DocumentHighlight]:
    if file := ls.robots_files.get(params.text_document.uri):
        return robots_file.highlights(ls, file, params)
    document, symbol = symbol_under(ls, params)
    if not document or not symbol:
        return []
    found = finding.references(document.analysis, symbol)
    return [highlight(document.lines, each, ls.editor.encoding) for each in found]
