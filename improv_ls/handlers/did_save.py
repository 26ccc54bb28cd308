"""textDocument/willSave and didSave: saving plays."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.code_lens import scene_ids
from improv_ls.handlers.workspace_files import refresh_robots
from improv_ls.session import Session


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


def _show_lenses_of_new_scenes(ls: Session, uri: str) -> None:
    """Show the lenses of scenes only with a save, because no line should move while a person types."""
    if document := ls.documents.get(uri):
        before = ls.scenes_with_lenses.pop(uri, None)
        now = None if document.analysis.earlier else scene_ids(document.analysis)
        if now is not None:
            ls.scenes_with_lenses[uri] = now
        if now is None or now != before:
            ls.editor.refresh("code_lens")
