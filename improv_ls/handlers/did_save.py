"""textDocument/willSave and didSave: saving plays."""

from __future__ import annotations

from lsprotocol import types

from improv_ls.handlers.workspace_files import refresh_robots
from improv_ls.session import Session


def will_save(ls: Session, params: types.WillSaveTextDocumentParams) -> None:
    """Remember an autosave: robots must not move because somebody looked at another window."""
    if params.reason != types.TextDocumentSaveReason.Manual:
        ls.autosaving.add(params.text_document.uri)
    else:
        ls.autosaving.discard(params.text_document.uri)  # an autosave before may have failed


def did_save(ls: Session, params: types.DidSaveTextDocumentParams) -> None:
    uri = params.text_document.uri
    if uri in ls.autosaving:
        ls.autosaving.remove(uri)
        return
    refresh_robots(ls)
    # What was saved is what plays, whatever is typed from here on.
    document = ls.documents.get(uri)
    if document and ls.editor.settings.study_log:
        ls.records.saved(document)
    if document and ls.editor.settings.on_save != "off":
        ls.editor.soon(ls.performance.play(document, ls.arrival.stops, "save"))
