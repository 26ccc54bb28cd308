"""workspace/didChangeWatchedFiles, didChangeWorkspaceFolders, didRenameFiles and didDeleteFiles."""

from __future__ import annotations

from dataclasses import replace

from lsprotocol import types

from improv_ls.documents import Document, is_robots_file, moved, robots_of
from improv_ls.handlers.diagnostics import publish_robots_file
from improv_ls.handlers.text_document_sync import add, did_close, refresh_robots
from improv_ls.session import Session


def did_change_watched_files(ls: Session, params: types.DidChangeWatchedFilesParams) -> None:
    """Handle an `improv.toml`, a URDF that one may name, or a program that was created, changed or deleted, perhaps
    with its folder."""
    ls.files_changed()
    if any(each.uri.endswith(".urdf") for each in params.changes):
        urdfs_changed(ls)
    elif any(is_robots_file(each.uri) or each.type == types.FileChangeType.Deleted for each in params.changes):
        refresh_robots(ls)


def urdfs_changed(ls: Session) -> None:
    """Check all programs and open `improv.toml` files against the current URDFs."""
    ls.files_changed()
    refresh_robots(ls)
    for file in ls.robots_files.values():
        publish_robots_file(ls, file)


def did_change_workspace_folders(ls: Session, params: types.DidChangeWorkspaceFoldersParams) -> None:
    """Handle folders that came or went; pygls keeps the list."""
    ls.files_changed()


def did_rename_files(ls: Session, params: types.RenameFilesParams) -> None:
    """Handle renamed files or folders. Most editors close their documents and open them again, some do neither."""
    ls.files_changed()
    for renamed in params.files:
        for document in list(ls.documents.values()):
            uri = moved(document.uri, renamed.old_uri, renamed.new_uri)
            if uri not in ls.documents:
                add(ls, Document(uri, document.version, document.analysis.with_robots(robots_of(uri))))
                did_close(ls, types.DidCloseTextDocumentParams(types.TextDocumentIdentifier(document.uri)))
        for file in list(ls.robots_files.values()):
            uri = moved(file.uri, renamed.old_uri, renamed.new_uri)
            if uri not in ls.robots_files:
                ls.robots_files[uri] = replace(ls.robots_files.pop(file.uri), uri=uri)
        ls.performance.playing.renamed(renamed.old_uri, renamed.new_uri)
    refresh_robots(ls)


def did_delete_files(ls: Session, params: types.DeleteFilesParams) -> None:
    """Handle an `improv.toml` that may be gone. Documents stay open until the editor closes them."""
    ls.files_changed()
    refresh_robots(ls)
