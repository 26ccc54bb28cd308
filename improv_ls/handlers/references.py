"""textDocument/references."""

from __future__ import annotations

from lsprotocol import types
from pygls.uris import from_fs_path

from improv_core.ide import references as finding
from improv_core.ide.references import Symbol, symbol_at
from improv_core.text import LineIndex
from improv_ls.documents import Document, robots_of
from improv_ls.handlers import robots_file
from improv_ls.positions import to_offset
from improv_ls.session import Session
from improv_ls.to_lsp_locations import location


def references(ls: Session, params: types.ReferenceParams) -> list[types.Location]:
    if file := ls.robots_files.get(params.text_document.uri):
        return robots_file.references(ls, file, params)
    document, symbol = symbol_under(ls, params)
    if not document or not symbol:
        return []
    declared = params.context.include_declaration
    return [
        *(sections(ls, document, symbol) if declared else []),
        *(
            location(document.uri, document.lines, each.span, ls.editor.encoding)
            for each in finding.references(document.analysis, symbol)
            if declared or not each.defines
        ),
    ]


_Asked = types.DefinitionParams | types.ReferenceParams | types.DocumentHighlightParams


def symbol_under(ls: Session, params: _Asked) -> tuple[Document | None, Symbol | None]:
    """Return the document, and the name or robot under the cursor."""
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None, None
    return document, symbol_at(document.analysis, to_offset(document.lines, params.position, ls.editor.encoding))


def sections(ls: Session, document: Document, symbol: Symbol) -> list[types.Location]:
    """Return the sections about a robot in the current `improv.toml`."""
    if not symbol.is_robot:
        return []
    robots = robots_of(document.uri)
    lines, spans = LineIndex(robots.text), finding.sections(robots, symbol.text)
    uri = from_fs_path(str(robots.path)) if robots.path else None
    return [location(uri, lines, span, ls.editor.encoding) for span in spans] if uri else []
