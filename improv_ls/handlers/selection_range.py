"""textDocument/selectionRange."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.selection_range import selections
from improv_ls import to_lsp_locations as to_lsp
from improv_ls.positions import to_offset
from improv_ls.session import Session


def selection_range(ls: Session, params: types.SelectionRangeParams) -> list[types.SelectionRange] | None:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    offsets = (to_offset(document.lines, position, ls.editor.encoding) for position in params.positions)
    spans = (selections(document.analysis, offset) for offset in offsets)
    return [to_lsp.selection_range(document.lines, each, ls.editor.encoding) for each in spans]
