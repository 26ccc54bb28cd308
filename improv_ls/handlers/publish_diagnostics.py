"""textDocument/publishDiagnostics: sent with every version of a document to editors that do not ask for them."""

from __future__ import annotations

from dataclasses import replace

from lsprotocol import types
from pygls.uris import from_fs_path

from improv_core.robots.config import Robots
from improv_core.text import LineIndex
from improv_ls import to_lsp
from improv_ls.documents import Document
from improv_ls.session import Session


def publish(ls: Session, document: Document) -> None:
    """Send the diagnostics of a version to an editor that does not ask for them."""
    if not ls.editor.pulls_diagnostics:
        params = types.PublishDiagnosticsParams(document.uri, diagnostics_of(ls, document), document.version)
        ls.text_document_publish_diagnostics(params)


def publish_robots(ls: Session, robots: Robots) -> None:
    """Send the diagnostics of an `improv.toml`: no editor asks us about files of other languages."""
    uri = from_fs_path(str(robots.path)) if robots.path else None
    if uri:
        lines, editor = LineIndex(robots.text), ls.editor
        items = [
            to_lsp.diagnostic(uri, lines, each, editor.encoding, editor.diagnostic_support)
            for each in robots.diagnostics
        ]
        ls.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, items))


def withdraw(ls: Session, document: Document) -> None:
    """Clear the diagnostics of a document that was closed, and of its `improv.toml` if no other document uses it."""
    if not ls.editor.pulls_diagnostics:
        ls.text_document_publish_diagnostics(types.PublishDiagnosticsParams(document.uri, []))
    robots = document.analysis.cast
    if all(other.analysis.cast.path != robots.path for other in ls.documents.values()):
        publish_robots(ls, replace(robots, diagnostics=()))


def diagnostics_of(ls: Session, document: Document) -> list[types.Diagnostic]:
    encoding, support = ls.editor.encoding, ls.editor.diagnostic_support
    return [
        to_lsp.diagnostic(document.uri, document.lines, each, encoding, support)
        for each in document.analysis.diagnostics
    ]
