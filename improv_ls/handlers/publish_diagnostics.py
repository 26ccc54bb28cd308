"""textDocument/publishDiagnostics: sent with every version of a document to editors that do not ask for them."""

from __future__ import annotations

from dataclasses import replace

from lsprotocol import types
from pygls.uris import from_fs_path

from improv_core.robots.config import Robots, read_robots
from improv_core.text import LineIndex
from improv_ls import to_lsp
from improv_ls.documents import Document, RobotsFile, path_of
from improv_ls.session import Session


def publish(ls: Session, document: Document) -> None:
    """Send the diagnostics of a version to an editor that does not ask for them."""
    if not ls.editor.pulls_diagnostics:
        params = types.PublishDiagnosticsParams(document.uri, diagnostics_of(ls, document), document.version)
        ls.text_document_publish_diagnostics(params)


def publish_robots(ls: Session, robots: Robots) -> None:
    """Send the diagnostics of an `improv.toml` on disk, unless it is open: then those of the editor's text are sent."""
    uri = from_fs_path(str(robots.path)) if robots.path else None
    if uri and uri not in ls.robots_files:
        lines, editor = LineIndex(robots.text), ls.editor
        items = [
            to_lsp.diagnostic(uri, lines, each, editor.encoding, editor.diagnostic_support)
            for each in robots.diagnostics
        ]
        ls.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, items))


def publish_robots_file(ls: Session, file: RobotsFile) -> None:
    """Send the diagnostics of a version of an open `improv.toml`."""
    editor = ls.editor
    items = [
        to_lsp.diagnostic(file.uri, file.lines, each, editor.encoding, editor.diagnostic_support)
        for each in read_robots(file.lines.text).diagnostics
    ]
    ls.text_document_publish_diagnostics(types.PublishDiagnosticsParams(file.uri, items, file.version))


def withdraw(ls: Session, document: Document) -> None:
    """Clear the diagnostics of a document that was closed, and of its `improv.toml` if no other document uses it."""
    if not ls.editor.pulls_diagnostics:
        ls.text_document_publish_diagnostics(types.PublishDiagnosticsParams(document.uri, []))
    robots = document.analysis.cast
    if all(other.analysis.cast.path != robots.path for other in ls.documents.values()):
        publish_robots(ls, replace(robots, diagnostics=()))


def withdraw_robots(ls: Session, uri: str) -> None:
    """Once an `improv.toml` is closed, show the errors on disk again if a program uses it, otherwise none."""
    path = path_of(uri)
    user = next((each for each in ls.documents.values() if each.analysis.cast.path == path), None)
    publish_robots(ls, user.analysis.cast if user else Robots(path=path))


def diagnostics_of(ls: Session, document: Document) -> list[types.Diagnostic]:
    encoding, support = ls.editor.encoding, ls.editor.diagnostic_support
    return [
        to_lsp.diagnostic(document.uri, document.lines, each, encoding, support)
        for each in document.analysis.diagnostics
    ]
