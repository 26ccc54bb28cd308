"""Diagnostics: asked for by editors that can, else sent with every version of a document."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import count
from typing import NamedTuple

from lsprotocol import types
from pygls.uris import from_fs_path

from improv_core.robots.config import Robots
from improv_core.text import LineIndex
from improv_ls import to_lsp
from improv_ls.documents import Document
from improv_ls.session import Session

_numbers = count(1)  # never the same for two reports, also of different documents


class Report(NamedTuple):
    """What an editor has been told of a document, and under which name it will speak of that."""

    result_id: str
    items: Sequence[types.Diagnostic]


def diagnostic(
    ls: Session, params: types.DocumentDiagnosticParams
) -> types.RelatedFullDocumentDiagnosticReport | types.RelatedUnchangedDocumentDiagnosticReport:
    """All that is to be said of a document, or that it is what was said last."""
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return types.RelatedFullDocumentDiagnosticReport([])
    items = _items(ls, document)
    before = ls.reports.get(document.uri)
    if before and before.result_id == params.previous_result_id and before.items == items:
        return types.RelatedUnchangedDocumentDiagnosticReport(before.result_id)
    report = ls.reports[document.uri] = Report(str(next(_numbers)), items)
    return types.RelatedFullDocumentDiagnosticReport(items, result_id=report.result_id)


def publish(ls: Session, document: Document) -> None:
    """Send the diagnostics of a version to an editor that does not ask for them."""
    if not ls.pulls:
        params = types.PublishDiagnosticsParams(document.uri, _items(ls, document), document.version)
        ls.text_document_publish_diagnostics(params)


def publish_robots(ls: Session, robots: Robots) -> None:
    """Send what is wrong with an `improv.toml`: nobody asks about files of other languages."""
    uri = from_fs_path(str(robots.path)) if robots.path else None
    if uri:
        lines = LineIndex(robots.text)
        items = [to_lsp.diagnostic(uri, lines, each, ls.encoding, ls.takes) for each in robots.diagnostics]
        ls.text_document_publish_diagnostics(types.PublishDiagnosticsParams(uri, items))


def forget(ls: Session, document: Document) -> None:
    """Take back what was said of a document that has been closed, and of its `improv.toml` if it was the last one."""
    ls.reports.pop(document.uri, None)
    if not ls.pulls:
        ls.text_document_publish_diagnostics(types.PublishDiagnosticsParams(document.uri, []))
    robots = document.analysis.cast
    if all(other.analysis.cast.path != robots.path for other in ls.documents.values()):
        publish_robots(ls, replace(robots, diagnostics=()))


def _items(ls: Session, document: Document) -> list[types.Diagnostic]:
    return [
        to_lsp.diagnostic(document.uri, document.lines, each, ls.encoding, ls.takes)
        for each in document.analysis.diagnostics
    ]
