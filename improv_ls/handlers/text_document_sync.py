"""textDocument/didOpen, didChange, willSave, didSave and didClose: saving plays."""

from __future__ import annotations

from dataclasses import replace

from lsprotocol import types

from improv_core.program.program import scene_ids
from improv_core.protocol.editing import NO_DRAFT
from improv_core.text import LineIndex
from improv_ls.documents import (
    Document,
    RobotsFile,
    changed,
    changed_file,
    is_program,
    is_robots_file,
    opened,
    robots_of,
)
from improv_ls.handlers.diagnostics import publish_robots, publish_robots_file, withdraw, withdraw_robots
from improv_ls.session import Session


def did_open(ls: Session, params: types.DidOpenTextDocumentParams) -> None:
    given = params.text_document
    _ = ls.settling  # made before anything reads a URDF, so that it is read in slices
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


def will_save(ls: Session, params: types.WillSaveTextDocumentParams) -> None:
    """Note whether a person asked for this save, and the number of stops before it: an autosave must not move robots,
    and neither must a save if somebody pressed stop before the editor had finished it."""
    by_person = params.reason == types.TextDocumentSaveReason.Manual
    ls.saving[ls.as_opened(params.text_document.uri)] = ls.arrival.stops if by_person else None


def did_save(ls: Session, params: types.DidSaveTextDocumentParams) -> None:
    uri = ls.as_opened(params.text_document.uri)
    _show_lenses_of_new_scenes(ls, uri)
    asked = ls.saving.pop(uri, ls.arrival.stops)
    if asked is None:
        return
    refresh_robots(ls)
    # The saved text plays, no matter what the person types from here on.
    document = ls.documents.get(uri)
    if document and ls.editor.settings.on_save != "off":
        ls.editor.soon(ls.performance.play(document, asked, text=params.text))


def add(ls: Session, document: Document) -> None:
    """Keep a new document, or one whose robots are new."""
    ls.settling.keep(document)
    publish_robots(ls, document.analysis.config)


def refresh_robots(ls: Session) -> None:
    """Check each document against the robots that the nearest `improv.toml` has now."""
    different = False
    for document in list(ls.documents.values()):
        robots = robots_of(document.uri)
        if robots != document.analysis.config:
            if robots.path != document.analysis.config.path:
                publish_robots(ls, replace(document.analysis.config, diagnostics=()))
            add(ls, replace(document, analysis=document.analysis.with_robots(robots)))
            different = True
    if different and ls.editor.pulls_diagnostics:
        ls.editor.refresh("diagnostics")


def _show_lenses_of_new_scenes(ls: Session, uri: str) -> None:
    """Show the lenses of scenes only with a save, because no line should move while a person types."""
    if document := ls.documents.get(uri):
        before = ls.scenes_with_lenses.pop(uri, None)
        now = None if document.analysis.earlier else scene_ids(document.analysis)
        if now is not None:
            ls.scenes_with_lenses[uri] = now
        if now is None or now != before:
            ls.editor.refresh("code_lens")


def _keep_robots(ls: Session, file: RobotsFile) -> None:
    ls.robots_files[file.uri] = file
    publish_robots_file(ls, file)
