"""textDocument/definition, and textDocument/declaration, which is the same in a program."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide import references as finding
from improv_core.ide.body_definition import declarations
from improv_ls.documents import Document, on_disk, robots_of
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
    return [location(document, span, ls.editor.encoding)] if span else []


def _declared(ls: Session, document: Document, position: types.Position) -> list[types.Location]:
    """Return the place where the current `improv.toml` declares the body part or the pose under the cursor."""
    robots = robots_of(document.uri)
    if not (file := on_disk(robots)):
        return []
    offset = to_offset(document.lines, position, ls.editor.encoding)
    spans = declarations(document.analysis, offset, robots)[:1]
    return [location(file, span, ls.editor.encoding) for span in spans]
