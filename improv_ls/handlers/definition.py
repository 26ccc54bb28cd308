"""textDocument/definition."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide import references as finding
from improv_ls.handlers import robots_file
from improv_ls.handlers.references import sections, symbol_under
from improv_ls.session import Session
from improv_ls.to_lsp_locations import location


def definition(ls: Session, params: types.DefinitionParams) -> list[types.Location]:
    if file := ls.robots_files.get(params.text_document.uri):
        return robots_file.definition(ls, file, params)
    document, symbol = symbol_under(ls, params)
    if not document or not symbol:
        return []
    if found := sections(ls, document, symbol):
        return found[:1]
    span = finding.definition(document.analysis, symbol)
    return [location(document.uri, document.lines, span, ls.editor.encoding)] if span else []
