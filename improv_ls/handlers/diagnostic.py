"""textDocument/diagnostic."""

from __future__ import annotations

from lsprotocol import types

from improv_ls.handlers.publish_diagnostics import diagnostics_of
from improv_ls.session import Session, sent


def diagnostic(
    ls: Session, params: types.DocumentDiagnosticParams
) -> types.RelatedFullDocumentDiagnosticReport | types.RelatedUnchangedDocumentDiagnosticReport:
    """All diagnostics of a document, or that they are those that were sent last."""
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return types.RelatedFullDocumentDiagnosticReport([])
    items = diagnostics_of(ls, document)
    before = ls.sent_diagnostics.get(document.uri)
    if before and before.result_id == params.previous_result_id and before.items == items:
        return types.RelatedUnchangedDocumentDiagnosticReport(before.result_id)
    now = ls.sent_diagnostics[document.uri] = sent(items)
    return types.RelatedFullDocumentDiagnosticReport(items, result_id=now.result_id)
