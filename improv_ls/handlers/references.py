"""textDocument/references."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide import references as finding
from improv_core.ide.references import Symbol, symbol_at
from improv_core.slices import in_slices
from improv_ls.documents import Document, on_disk, robots_of
from improv_ls.positions import to_offset
from improv_ls.session import Session
from improv_ls.to_lsp_locations import location


def references(ls: Session, document: Document, params: types.ReferenceParams) -> list[types.Location]:
    symbol = symbol_under(ls, document, params.position)
    if not symbol:
        return []
    declared = params.context.include_declaration
    return [
        *(sections(ls, document, symbol) if declared else []),
        *(
            location(document, each.span, ls.editor.encoding)
            for each in in_slices(finding.references(document.analysis, symbol))
            if declared or not each.defines
        ),
    ]


def symbol_under(ls: Session, document: Document, position: types.Position) -> Symbol | None:
    """Return the name or robot under the cursor."""
    return symbol_at(document.analysis, to_offset(document.lines, position, ls.editor.encoding))


def sections(ls: Session, document: Document, symbol: Symbol) -> list[types.Location]:
    """Return the sections about a robot in the current `improv.toml`."""
    if symbol.kind != "robot":
        return []
    robots = robots_of(document.uri)
    spans, file = finding.sections(robots, symbol.text), on_disk(robots)
    return [location(file, span, ls.editor.encoding) for span in spans] if file else []
