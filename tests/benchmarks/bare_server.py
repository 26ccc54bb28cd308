"""The smallest pygls server: it says of every version of a document that nothing is wrong with it."""

from __future__ import annotations

from lsprotocol import types
from pygls.lsp.server import LanguageServer

server = LanguageServer("bare", "1")


@server.feature(types.TEXT_DOCUMENT_DID_OPEN)
def did_open(ls: LanguageServer, params: types.DidOpenTextDocumentParams) -> None:
    publish(ls, params.text_document)


@server.feature(types.TEXT_DOCUMENT_DID_CHANGE)
def did_change(ls: LanguageServer, params: types.DidChangeTextDocumentParams) -> None:
    publish(ls, params.text_document)


def publish(ls: LanguageServer, document: types.TextDocumentItem | types.VersionedTextDocumentIdentifier) -> None:
    params = types.PublishDiagnosticsParams(uri=document.uri, version=document.version, diagnostics=[])
    ls.text_document_publish_diagnostics(params)


if __name__ == "__main__":
    server.start_io()
