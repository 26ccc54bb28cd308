"""textDocument/didOpen, didChange, didClose: the text, and its diagnostics."""

from __future__ import annotations

from dataclasses import replace

from lsprotocol import types

from improv_ls import to_lsp
from improv_ls.documents import Document, changed, opened, robots_of
from improv_ls.session import Session


def did_open(ls: Session, params: types.DidOpenTextDocumentParams) -> None:
    given = params.text_document
    document = opened(given.uri, given.version, given.text)
    _keep(ls, document)
    _publish_robots(ls, document)
    if ls.settings.on_save != "off":
        ls.soon(ls.performance.warm_up())


def did_change(ls: Session, params: types.DidChangeTextDocumentParams) -> None:
    document = ls.documents.get(params.text_document.uri)
    if document:
        _keep(ls, changed(document, params.text_document.version, params.content_changes, ls.encoding))


def did_close(ls: Session, params: types.DidCloseTextDocumentParams) -> None:
    uri = params.text_document.uri
    ls.documents.pop(uri, None)
    ls.colorings.pop(uri, None)
    ls.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri=uri, diagnostics=[]))


def did_change_watched_files(ls: Session, params: types.DidChangeWatchedFilesParams) -> None:
    """An `improv.toml` has come, changed or gone."""
    for document in list(ls.documents.values()):
        refresh_robots(ls, document)


def refresh_robots(ls: Session, document: Document) -> Document:
    """The document with the robots that the nearest `improv.toml` has now."""
    robots = robots_of(document.uri)
    if robots != document.analysis.cast:
        if old := to_lsp.robots_diagnostics(replace(document.analysis.cast, diagnostics=()), ls.encoding):
            ls.text_document_publish_diagnostics(old)
        document = replace(document, analysis=document.analysis.with_robots(robots))
        _keep(ls, document)
        _publish_robots(ls, document)
    return document


def _keep(ls: Session, document: Document) -> None:
    ls.documents[document.uri] = document
    ls.text_document_publish_diagnostics(to_lsp.diagnostics(document, ls.encoding))


def _publish_robots(ls: Session, document: Document) -> None:
    if params := to_lsp.robots_diagnostics(document.analysis.cast, ls.encoding):
        ls.text_document_publish_diagnostics(params)
