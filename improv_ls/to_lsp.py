"""The core's plain data as lsprotocol's types."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from lsprotocol import types

from improv_core.diagnostics import FADED, Diagnostic, Severity
from improv_core.plain import without_links
from improv_core.text import LineIndex, Span
from improv_ls.code_description import href
from improv_ls.documents import AnyDocument
from improv_ls.positions import Encoding, json_range, to_range

if TYPE_CHECKING:  # diagnostics must not wait for these
    from improv_core.ide.completion import Completion
    from improv_core.ide.hover import Hover
    from improv_core.ide.signature_help import Signature

_NUMBER = re.compile(r"(?<![\w.])\d[\d.]*$")
_SEVERITIES = {
    Severity.ERROR: types.DiagnosticSeverity.Error,
    Severity.WARNING: types.DiagnosticSeverity.Warning,
    Severity.INFORMATION: types.DiagnosticSeverity.Information,
    Severity.HINT: types.DiagnosticSeverity.Hint,
}

_KINDS = {
    "keyword": types.CompletionItemKind.Keyword,
    "movement": types.CompletionItemKind.Unit,  # some editors write a call's brackets after a function
    "name": types.CompletionItemKind.Variable,
    "phrase": types.CompletionItemKind.Variable,
    "parameter": types.CompletionItemKind.Variable,
    "robot": types.CompletionItemKind.Class,
    "plane": types.CompletionItemKind.Enum,  # LSP 3.0 has no EnumMember
    "sense": types.CompletionItemKind.Property,
    "number": types.CompletionItemKind.Value,
    "section": types.CompletionItemKind.Module,
    "key": types.CompletionItemKind.Property,
    "value": types.CompletionItemKind.Value,
}


class DiagnosticSupport(NamedTuple):
    """The parts of a diagnostic that a client supports, besides its range and message."""

    related_information: bool
    tags: bool
    code_description: bool


def diagnostic(uri: str, lines: LineIndex, found: Diagnostic, encoding: Encoding, support: DiagnosticSupport) -> Any:
    """Return the JSON of a `types.Diagnostic`: most keys send some, and to make that of objects takes twice as long."""
    made: dict[str, object] = {
        "range": json_range(lines, found.span, encoding),
        "message": without_links(found.message),
        "severity": _SEVERITIES[found.severity],
        "code": found.code,
        "source": "improv",
    }
    if support.code_description and (page := href(found.code)):
        made["codeDescription"] = {"href": page}
    if support.tags and found.code in FADED:
        made["tags"] = [types.DiagnosticTag.Unnecessary]
    if support.related_information and found.related:
        made["relatedInformation"] = [
            {
                "location": {"uri": uri, "range": json_range(lines, other.span, encoding)},
                "message": without_links(other.message),
            }
            for other in found.related
        ]
    return made


def markup(found: Hover, formats: Sequence[str] | None) -> types.MarkupContent:
    """Convert to Markdown for clients that show it, to plain text for others."""
    if types.MarkupKind.Markdown in (formats or ()):
        return types.MarkupContent(types.MarkupKind.Markdown, found.markdown)
    return types.MarkupContent(types.MarkupKind.PlainText, found.plain)


def completion(document: AnyDocument, found: Completion, snippets: bool, encoding: Encoding) -> types.CompletionList:
    """Convert the completions in our order; as snippets for clients that support them."""
    start, end = found.span.start, found.span.end
    typed = _NUMBER.search(document.lines.text, max(start - 20, 0), start) if snippets or start == end else None
    begun = typed[0] if typed else ""  # editors compare labels with all that is directly before the cursor
    written = begun if snippets else ""  # ALE, which has no snippets, never replaces a number
    replaced = to_range(document.lines, Span(start - len(written), end), encoding)
    items = []
    for number, item in enumerate(found.items):
        snippet = snippets and item.snippet
        items.append(
            types.CompletionItem(
                label=begun + item.label,
                kind=_KINDS[item.kind],
                detail=item.detail,
                sort_text=f"{number:04}",
                filter_text=begun + item.label,
                text_edit=types.TextEdit(replaced, written + (item.snippet if snippet else item.label)),
                insert_text_format=types.InsertTextFormat.Snippet if snippet else None,
                data=[document.uri, found.statement, item.kind],
            )
        )
    return types.CompletionList(is_incomplete=not found.whole, items=items)


def signature(found: Signature) -> types.SignatureHelp:
    parameters = [types.ParameterInformation(found.label[slice(*span)]) for span in found.parameters]
    about = types.SignatureInformation(found.label, found.about, parameters)
    return types.SignatureHelp([about], active_signature=0, active_parameter=found.active)
