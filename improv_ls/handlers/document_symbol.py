"""textDocument/documentSymbol."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.document_symbol import flattened, outline
from improv_core.ide.robots_file import document_symbol as robots_file
from improv_ls import to_lsp_locations as to_lsp
from improv_ls.session import Session


def document_symbol(
    ls: Session, params: types.DocumentSymbolParams
) -> list[types.DocumentSymbol] | list[types.SymbolInformation]:
    uri, encoding = params.text_document.uri, ls.editor.encoding
    if file := ls.robots_files.get(uri):
        entries, flat, lines = robots_file.outline(file.lines.text), robots_file.flattened, file.lines
    elif document := ls.documents.get(uri):
        entries, flat, lines = outline(document.analysis), flattened, document.lines
    else:
        return []
    if ls.editor.can("text_document.document_symbol.hierarchical_document_symbol_support"):
        return [to_lsp.document_symbol(lines, entry, encoding) for entry in entries]
    return [to_lsp.symbol_information(uri, lines, entry, encoding) for entry in flat(entries)]
