"""textDocument/didOpen, didChange and didClose."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from typing import Literal

from lsprotocol import types

from improv_core.text import LineIndex
from improv_ls.documents import (
    Document,
    RobotsFile,
    changed,
    changed_file,
    is_program,
    is_robots_file,
    opened,
    settled_further,
)
from improv_ls.handlers.publish_diagnostics import (
    publish,
    publish_robots,
    publish_robots_file,
    withdraw,
    withdraw_robots,
)
from improv_ls.session import Session


def did_open(ls: Session, params: types.DidOpenTextDocumentParams) -> None:
    given = params.text_document
    if is_robots_file(given.uri):
        _keep_robots(ls, RobotsFile(given.uri, given.version, LineIndex(given.text)))
    elif is_program(given.uri, given.language_id):
        add(ls, opened(given.uri, given.version, given.text))
        if ls.editor.settings.on_save != "off":
            ls.editor.soon(ls.performance.warm_up())


def did_change(ls: Session, params: types.DidChangeTextDocumentParams) -> None:
    given, changes = params.text_document, params.content_changes
    if file := ls.robots_files.get(given.uri):
        _keep_robots(ls, changed_file(file, given.version, changes, ls.editor.encoding))
    elif document := ls.documents.get(given.uri):
        document = changed(document, given.version, changes, ls.editor.encoding)
        _keep(ls, document)
        if document.analysis.waiting:
            ls.editor.soon(_settle(ls, document))


def did_close(ls: Session, params: types.DidCloseTextDocumentParams) -> None:
    uri = params.text_document.uri
    if ls.robots_files.pop(uri, None):
        withdraw_robots(ls, uri)
    if document := ls.documents.pop(uri, None):
        ls.sent_tokens.pop(uri, None)
        ls.sent_diagnostics.pop(uri, None)
        ls.autosaving.discard(uri)
        withdraw(ls, document)
        ls.files_changed()  # what is said about it is now what its file says


def add(ls: Session, document: Document) -> None:
    """Keep a document that is new, or whose robots are."""
    _keep(ls, document)
    publish_robots(ls, document.analysis.cast)


def _keep(ls: Session, document: Document) -> None:
    ls.documents[document.uri] = document
    publish(ls, document)


async def _settle(ls: Session, document: Document) -> None:
    """Bring all statements up to date in pieces, until the next key comes, and show what that changes."""
    now: Document | None = document
    while now and now.analysis.waiting:
        ls.documents[document.uri] = settled_further(now)
        await asyncio.sleep(0)  # the next key is read here
        now = ls.documents.get(document.uri)
        if now and now.lines is not document.lines:
            return
    if now:
        publish(ls, now)
        for feature in _SHOWN:
            ls.editor.refresh(feature)


_SHOWN: Sequence[Literal["code_lens", "diagnostics", "inlay_hint"]] = ("diagnostics", "inlay_hint", "code_lens")


def _keep_robots(ls: Session, file: RobotsFile) -> None:
    ls.robots_files[file.uri] = file
    publish_robots_file(ls, file)
