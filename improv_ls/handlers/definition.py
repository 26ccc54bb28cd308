"""textDocument/definition."""

from __future__ import annotations

from lsprotocol import types
from pygls.uris import from_fs_path

from improv_core.ide import references as finding
from improv_core.ide.body_definition import declarations
from improv_core.text import LineIndex
from improv_ls.documents import Document, robots_of
from improv_ls.handlers import robots_file
from improv_ls.handlers.references import sections, symbol_under
from improv_ls.positions import to_offset
from improv_ls.session import Session
from improv_ls.to_lsp_locations import location


def definition(ls: Session, params: types.DefinitionParams) -> list[types.Location]:
    if file := ls.robots_files.get(params.text_document.uri):
        return robots_file.definition(ls, file, params)
    document, symbol = symbol_under(ls, params)
    if not document:
        return []
    if found := _declared(ls, document, params):
        return found
    if not symbol:
        return []
    if found := sections(ls, document, symbol):
        return found[:1]
    span = finding.definition(document.analysis, symbol)
    return [location(document.uri, document.lines, span, ls.editor.encoding)] if span else []


def _declared(ls: Session, document: Document, params: types.DefinitionParams) -> list[types.Location]:
    """Return the place where the current `improv.toml` declares the body part or the pose under the cursor."""
    robots = robots_of(document.uri)
    if not robots.path:
        return []
    offset = to_offset(document.lines, params.position, ls.editor.encoding)
    spans, lines = declarations(document.analysis, offset, robots)[:1], LineIndex(robots.text)
    return [location(from_fs_path(str(robots.path)) or "", lines, span, ls.editor.encoding) for span in spans]
