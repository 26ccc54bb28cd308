"""textDocument/didOpen, didChange and didClose."""

from __future__ import annotations

from lsprotocol import types

from improv_core.protocol.editing import NO_DRAFT
from improv_core.text import LineIndex
from improv_ls.documents import Document, RobotsFile, changed, changed_file, is_program, is_robots_file, opened
from improv_ls.handlers.diagnostics import publish_robots, publish_robots_file, withdraw, withdraw_robots
from improv_ls.session import Session


def did_open(ls: Session, params: types.DidOpenTextDocumentParams) -> None:
    given, _ = params.text_document, ls.settling  # that reads URDFs in slices from now on
    if is_robots_file(given.uri):
        _keep_robots(ls, RobotsFile(given.uri, given.version, LineIndex(given.text)))
    elif is_program(given.uri, given.language_id):
        if ls.editor.settings.on_save != "off":
            ls.editor.soon(ls.performance.warm_up())  # first: stages start while the program is read
        document = opened(given.uri, given.version, given.text)
        ls.scenes_with_lenses.pop(given.uri, None)
        add(ls, document)


def did_change(ls: Session, params: types.DidChangeTextDocumentParams) -> None:
    given, changes = params.text_document, params.content_changes
    if file := ls.robots_files.get(given.uri):
        _keep_robots(ls, changed_file(file, given.version, changes, ls.editor.encoding))
    elif document := ls.documents.get(given.uri):
        ls.settling.keep(changed(document, given.version, changes, ls.editor.encoding))


def did_close(ls: Session, params: types.DidCloseTextDocumentParams) -> None:
    uri = params.text_document.uri
    if ls.robots_files.pop(uri, None):
        withdraw_robots(ls, uri)
    if document := ls.documents.pop(uri, None):
        ls.settling.drop(uri)
        if ls.is_on_pages(document):
            ls.performance.ask(NO_DRAFT)
        ls.sent_tokens.pop(uri, None)
        ls.sent_diagnostics.pop(uri, None)
        ls.scenes_with_lenses.pop(uri, None)
        ls.saving.pop(uri, None)
        withdraw(ls, document)
        ls.files_changed()  # its diagnostics come from its file from now on


def add(ls: Session, document: Document) -> None:
    """Keep a new document, or one whose robots are new."""
    ls.settling.keep(document)
    publish_robots(ls, document.analysis.config)


def _keep_robots(ls: Session, file: RobotsFile) -> None:
    ls.robots_files[file.uri] = file
    publish_robots_file(ls, file)
