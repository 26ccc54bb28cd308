"""Requests about the text: each converts the position, asks the core, and converts the answer."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.completion import complete
from improv_core.ide.hover import hover as hover_at
from improv_ls import to_lsp
from improv_ls.positions import to_offset
from improv_ls.session import Session


def hover(ls: Session, params: types.HoverParams) -> types.Hover | None:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    found = hover_at(document.analysis, to_offset(document.lines, params.position, ls.encoding))
    return to_lsp.hover(document, found, ls.encoding) if found else None


def completion(ls: Session, params: types.CompletionParams) -> list[types.CompletionItem]:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return []
    items = complete(document.analysis, to_offset(document.lines, params.position, ls.encoding))
    return [to_lsp.completion(document, item, ls.encoding) for item in items]
