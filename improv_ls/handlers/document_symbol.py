"""textDocument/documentSymbol."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.document_symbol import flattened, outline
from improv_ls import to_lsp_locations as to_lsp
from improv_ls.session import Session


def document_symbol(
    ls: Session, params: types.DocumentSymbolParams
) -> list[types.DocumentSymbol] | list[types.SymbolInformation]:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return []
    entries, lines, encoding = outline(document.analysis), document.lines, ls.editor.encoding
    if ls.editor.can("text_document.document_symbol.hierarchical_document_symbol_support"):
        return [to_lsp.document_symbol(lines, entry, encoding) for entry in entries]
    return [to_lsp.symbol_information(document.uri, lines, entry, encoding) for entry in flattened(entries)]
