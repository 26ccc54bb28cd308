"""textDocument/definition, and textDocument/declaration, which is the same in a program."""

from __future__ import annotations

from lsprotocol import types
from pygls.uris import from_fs_path

from improv_core.ide import references as finding
from improv_core.ide.body_definition import declarations
from improv_core.text import LineIndex
from improv_ls.documents import Document, robots_of
from improv_ls.handlers.references import sections, symbol_under
from improv_ls.positions import to_offset
from improv_ls.session import Session
from improv_ls.to_lsp_locations import location


def definition(
    ls: Session, document: Document, params: types.DefinitionParams | types.DeclarationParams
) -> list[types.Location]:
    if found := _declared(ls, document, params.position):
        return found
    symbol = symbol_under(ls, document, params.position)
    if not symbol:
        return []
    if found := sections(ls, document, symbol):
        return found[:1]
    span = finding.definition(document.analysis, symbol)
    return [location(document.uri, document.lines, span, ls.editor.encoding)] if span else []


def _declared(ls: Session, document: Document, position: types.Position) -> list[types.Location]:
    """Return the place where the current `improv.toml` declares the body part or the pose under the cursor."""
    robots = robots_of(document.uri)
    if not robots.path:
        return []
    offset = to_offset(document.lines, position, ls.editor.encoding)
    spans, lines = declarations(document.analysis, offset, robots)[:1], LineIndex(robots.text)
    return [location(from_fs_path(str(robots.path)) or "", lines, span, ls.editor.encoding) for span in spans]
