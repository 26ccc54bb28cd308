"""textDocument/didOpen, didChange, didClose: the text, and its diagnostics."""

from __future__ import annotations

import asyncio

from lsprotocol import types

from improv_ls import to_lsp
from improv_ls.documents import Document, changed, opened
from improv_ls.session import Session


async def did_open(ls: Session, params: types.DidOpenTextDocumentParams) -> None:
    given = params.text_document
    _keep(ls, opened(given.uri, given.version, given.text))
    if ls.settings.on_save != "off":
        await asyncio.sleep(0)  # the diagnostics go first
        await ls.performance.warm_up()


def did_change(ls: Session, params: types.DidChangeTextDocumentParams) -> None:
    document = ls.documents.get(params.text_document.uri)
    if document:
        _keep(ls, changed(document, params.text_document.version, params.content_changes, ls.encoding))


def did_close(ls: Session, params: types.DidCloseTextDocumentParams) -> None:
    uri = params.text_document.uri
    ls.documents.pop(uri, None)
    ls.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri=uri, diagnostics=[]))


def _keep(ls: Session, document: Document) -> None:
    ls.documents[document.uri] = document
    ls.text_document_publish_diagnostics(to_lsp.diagnostics(document, ls.encoding))
