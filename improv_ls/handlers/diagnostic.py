"""textDocument/diagnostic."""

from __future__ import annotations

from typing import Any

from lsprotocol import types

from improv_ls.documents import Document
from improv_ls.handlers.publish_diagnostics import as_sent, diagnostics_of
from improv_ls.session import LastSent, Session, sent


def diagnostic(
    ls: Session, document: Document, params: types.DocumentDiagnosticParams
) -> types.RelatedFullDocumentDiagnosticReport | types.RelatedUnchangedDocumentDiagnosticReport:
    """Return all diagnostics of a document, or that they have not changed since they were sent last."""
    now = diagnosed(ls, document)
    if now.result_id == params.previous_result_id:
        return types.RelatedUnchangedDocumentDiagnosticReport(now.result_id)
    return types.RelatedFullDocumentDiagnosticReport(now.items, result_id=now.result_id)


def diagnosed(ls: Session, document: Document) -> LastSent[Any]:
    """Return the diagnostics of an open document, with the ID of those that were sent last if they are the same."""
    items = as_sent(ls, document, diagnostics_of(ls, document))
    before = ls.sent_diagnostics.get(document.uri)
    now = ls.sent_diagnostics[document.uri] = before if before and before.items == items else sent(items)
    return now
