"""textDocument/formatting, rangeFormatting and onTypeFormatting."""

from __future__ import annotations

from collections.abc import Sequence

from lsprotocol import types

from improv_core.diagnostics import Edit
from improv_core.ide.formatting import format_all, format_span
from improv_core.ide.on_type_formatting import indent
from improv_core.ide.robots_file import formatting as robots_file
from improv_ls.documents import AnyDocument, Document, RobotsFile
from improv_ls.positions import to_offset, to_range, to_span
from improv_ls.session import Session


def formatting(ls: Session, document: AnyDocument, params: types.DocumentFormattingParams) -> list[types.TextEdit]:
    if isinstance(document, RobotsFile):
        return _converted(ls, document, robots_file.format_file(document.lines.text))
    return _converted(ls, document, format_all(document.analysis))


def range_formatting(
    ls: Session, document: AnyDocument, params: types.DocumentRangeFormattingParams
) -> list[types.TextEdit]:
    span = to_span(document.lines, params.range, ls.editor.encoding)
    if isinstance(document, RobotsFile):
        return _converted(ls, document, robots_file.format_span(document.lines.text, span))
    return _converted(ls, document, format_span(document.analysis, span))


def on_type_formatting(
    ls: Session, document: Document, params: types.DocumentOnTypeFormattingParams
) -> list[types.TextEdit]:
    offset = to_offset(document.lines, params.position, ls.editor.encoding)
    return _converted(ls, document, indent(document.analysis, offset))


def _converted(ls: Session, document: AnyDocument, edits: Sequence[Edit]) -> list[types.TextEdit]:
    return [types.TextEdit(to_range(document.lines, edit.span, ls.editor.encoding), edit.text) for edit in edits]
