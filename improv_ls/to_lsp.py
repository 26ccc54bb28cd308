"""Plain data of the core to lsprotocol's types."""

from __future__ import annotations

from lsprotocol import types

from improv_core.diagnostics import FADED, Severity
from improv_core.ide.completion import Item
from improv_core.ide.hover import Hover
from improv_ls.documents import Document
from improv_ls.positions import Encoding, to_range

_SEVERITIES = {
    Severity.ERROR: types.DiagnosticSeverity.Error,
    Severity.WARNING: types.DiagnosticSeverity.Warning,
    Severity.INFORMATION: types.DiagnosticSeverity.Information,
    Severity.HINT: types.DiagnosticSeverity.Hint,
}

_KINDS = {
    "keyword": types.CompletionItemKind.Keyword,
    "movement": types.CompletionItemKind.Function,
    "name": types.CompletionItemKind.Variable,
    "robot": types.CompletionItemKind.Class,
    "plane": types.CompletionItemKind.EnumMember,
}


def diagnostics(document: Document, encoding: Encoding | str) -> types.PublishDiagnosticsParams:
    return types.PublishDiagnosticsParams(
        uri=document.uri,
        version=document.version,
        diagnostics=[
            types.Diagnostic(
                range=to_range(document.lines, diagnostic.span, encoding),
                message=diagnostic.message,
                severity=_SEVERITIES[diagnostic.severity],
                code=diagnostic.code,
                source="improv",
                tags=[types.DiagnosticTag.Unnecessary] if diagnostic.code in FADED else None,
                related_information=[
                    types.DiagnosticRelatedInformation(
                        types.Location(document.uri, to_range(document.lines, other.span, encoding)), other.message
                    )
                    for other in diagnostic.related
                ]
                or None,
            )
            for diagnostic in document.analysis.diagnostics
        ],
    )


def hover(document: Document, found: Hover, encoding: Encoding | str) -> types.Hover:
    return types.Hover(
        contents=types.MarkupContent(types.MarkupKind.Markdown, found.text),
        range=to_range(document.lines, found.span, encoding),
    )


def completion(document: Document, item: Item, encoding: Encoding | str) -> types.CompletionItem:
    return types.CompletionItem(
        label=item.label,
        kind=_KINDS[item.kind],
        detail=item.detail,
        text_edit=types.TextEdit(range=to_range(document.lines, item.span, encoding), new_text=item.label),
    )
