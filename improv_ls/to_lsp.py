"""Plain data of the core to lsprotocol's types."""

from __future__ import annotations

from lsprotocol import types
from pygls.uris import from_fs_path

from improv_core.diagnostics import FADED, Diagnostic, Severity
from improv_core.ide.completion import Item
from improv_core.ide.hover import Hover
from improv_core.robots import Robots
from improv_core.text import LineIndex
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
    found = document.analysis.diagnostics
    converted = [_diagnostic(document.uri, document.lines, each, encoding) for each in found]
    return types.PublishDiagnosticsParams(document.uri, converted, document.version)


def robots_diagnostics(robots: Robots, encoding: Encoding | str) -> types.PublishDiagnosticsParams | None:
    """What is wrong with an `improv.toml`, in that file; None if there is no such file."""
    uri = from_fs_path(str(robots.path)) if robots.path else None
    if not uri:
        return None
    lines = LineIndex(robots.text)
    return types.PublishDiagnosticsParams(uri, [_diagnostic(uri, lines, each, encoding) for each in robots.diagnostics])


def _diagnostic(uri: str, lines: LineIndex, diagnostic: Diagnostic, encoding: Encoding | str) -> types.Diagnostic:
    related = [
        types.DiagnosticRelatedInformation(types.Location(uri, to_range(lines, other.span, encoding)), other.message)
        for other in diagnostic.related
    ]
    return types.Diagnostic(
        range=to_range(lines, diagnostic.span, encoding),
        message=diagnostic.message,
        severity=_SEVERITIES[diagnostic.severity],
        code=diagnostic.code,
        source="improv",
        tags=[types.DiagnosticTag.Unnecessary] if diagnostic.code in FADED else None,
        related_information=related or None,
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
