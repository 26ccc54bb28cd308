"""What the editor says of its documents and files: opened, changed, closed, renamed."""

from __future__ import annotations

from dataclasses import replace

from lsprotocol import types

from improv_ls.documents import Document, changed, moved, opened, robots_of
from improv_ls.handlers.diagnostics import forget, publish, publish_robots
from improv_ls.session import Session


def did_open(ls: Session, params: types.DidOpenTextDocumentParams) -> None:
    given = params.text_document
    _take_in(ls, opened(given.uri, given.version, given.text))
    if ls.settings.on_save != "off":
        ls.soon(ls.performance.warm_up())


def did_change(ls: Session, params: types.DidChangeTextDocumentParams) -> None:
    document = ls.documents.get(params.text_document.uri)
    if document:
        _keep(ls, changed(document, params.text_document.version, params.content_changes, ls.encoding))


def did_close(ls: Session, params: types.DidCloseTextDocumentParams) -> None:
    document = ls.documents.pop(params.text_document.uri, None)
    if document:
        ls.colorings.pop(document.uri, None)
        ls.saved_by_themselves.discard(document.uri)
        forget(ls, document)


def did_change_watched_files(ls: Session, params: types.DidChangeWatchedFilesParams) -> None:
    """An `improv.toml` has come, changed or gone."""
    refresh_robots(ls)


def did_rename_files(ls: Session, params: types.RenameFilesParams) -> None:
    """Files or folders have other names. Most editors close their documents and open them anew, some do neither."""
    for renamed in params.files:
        for document in list(ls.documents.values()):
            uri = moved(document.uri, renamed.old_uri, renamed.new_uri)
            if uri not in ls.documents:
                _take_in(ls, Document(uri, document.version, document.analysis.with_robots(robots_of(uri))))
                did_close(ls, types.DidCloseTextDocumentParams(types.TextDocumentIdentifier(document.uri)))
        ls.performance.renamed(renamed.old_uri, renamed.new_uri)
    refresh_robots(ls)


def did_delete_files(ls: Session, params: types.DeleteFilesParams) -> None:
    """An `improv.toml` may be gone. What is open stays open until the editor closes it."""
    refresh_robots(ls)


def refresh_robots(ls: Session) -> None:
    """Hold each document against the robots that the nearest `improv.toml` has now."""
    different = False
    for document in list(ls.documents.values()):
        robots = robots_of(document.uri)
        if robots != document.analysis.cast:
            publish_robots(ls, replace(document.analysis.cast, diagnostics=()))
            _take_in(ls, replace(document, analysis=document.analysis.with_robots(robots)))
            different = True
    if different and ls.pulls:
        ls.ask_again("diagnostics")


def _take_in(ls: Session, document: Document) -> None:
    """Keep a document whose robots we have not seen it with."""
    _keep(ls, document)
    publish_robots(ls, document.analysis.cast)


def _keep(ls: Session, document: Document) -> None:
    ls.documents[document.uri] = document
    publish(ls, document)
