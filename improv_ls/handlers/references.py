"""textDocument/declaration, which is the same as a definition in a program, definition, references, and
documentHighlight."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide import references as finding
from improv_core.ide.references import Symbol, symbol_at
from improv_core.ide.robots_file.body_names import declared
from improv_core.slices import in_slices
from improv_ls.documents import Document, on_disk, robots_of
from improv_ls.positions import to_offset
from improv_ls.session import Session
from improv_ls.to_lsp_locations import highlight, location


def definition(
    ls: Session, document: Document, params: types.DefinitionParams | types.DeclarationParams
) -> list[types.Location]:
    if found := _declared(ls, document, params.position):
        return found
    symbol = _symbol(ls, document, params.position)
    if not symbol:
        return []
    if found := _sections(ls, document, symbol):
        return found[:1]
    span = finding.definition(document.analysis, symbol)
    return [location(document, span, ls.editor.encoding)] if span else []


def references(ls: Session, document: Document, params: types.ReferenceParams) -> list[types.Location]:
    symbol = _symbol(ls, document, params.position)
    if not symbol:
        return []
    with_declared = params.context.include_declaration
    return [
        *(_sections(ls, document, symbol) if with_declared else []),
        *(
            location(document, each.span, ls.editor.encoding)
            for each in in_slices(finding.references(document.analysis, symbol))
            if with_declared or not each.defines
        ),
    ]


def document_highlight(
    ls: Session, document: Document, params: types.DocumentHighlightParams
) -> list[types.DocumentHighlight]:
    symbol = _symbol(ls, document, params.position)
    found = finding.references(document.analysis, symbol) if symbol else ()
    return [highlight(document.lines, each, ls.editor.encoding) for each in in_slices(found)]


def _declared(ls: Session, document: Document, position: types.Position) -> list[types.Location]:
    """Return the place where the current `improv.toml` declares the body part or the pose under the cursor."""
    robots = robots_of(document.uri)
    if not (file := on_disk(robots)):
        return []
    offset = to_offset(document.lines, position, ls.editor.encoding)
    spans = declared(document.analysis, offset, robots)[:1]
    return [location(file, span, ls.editor.encoding) for span in spans]


def _symbol(ls: Session, document: Document, position: types.Position) -> Symbol | None:
    """Return the name or robot under the cursor."""
    return symbol_at(document.analysis, to_offset(document.lines, position, ls.editor.encoding))


def _sections(ls: Session, document: Document, symbol: Symbol) -> list[types.Location]:
    """Return the sections about a robot in the current `improv.toml`."""
    if symbol.kind != "robot":
        return []
    robots = robots_of(document.uri)
    spans, file = finding.sections(robots, symbol.text), on_disk(robots)
    return [location(file, span, ls.editor.encoding) for span in spans] if file else []
