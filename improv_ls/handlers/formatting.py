"""textDocument/formatting, rangeFormatting and onTypeFormatting."""

from __future__ import annotations

from collections.abc import Sequence

from lsprotocol import types

from improv_core.diagnostics import Edit
from improv_core.ide.formatting import format_all, format_span
from improv_core.ide.on_type_formatting import indent
from improv_core.ide.robots_file import formatting as robots_file
from improv_ls.documents import Document, RobotsFile
from improv_ls.positions import to_offset, to_range, to_span
from improv_ls.session import Session


def formatting(ls: Session, params: types.DocumentFormattingParams) -> list[types.TextEdit] | None:
    if file := ls.robots_files.get(params.text_document.uri):
        return _converted(ls, file, robots_file.format_file(file.lines.text))
    document = ls.documents.get(params.text_document.uri)
    return _converted(ls, document, format_all(document.analysis)) if document else None


def range_formatting(ls: Session, params: types.DocumentRangeFormattingParams) -> list[types.TextEdit] | None:
    if file := ls.robots_files.get(params.text_document.uri):
        span = to_span(file.lines, params.range, ls.editor.encoding)
        return _converted(ls, file, robots_file.format_span(file.lines.text, span))
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    span = to_span(document.lines, params.range, ls.editor.encoding)
    return _converted(ls, document, format_span(document.analysis, span))


def on_type_formatting(ls: Session, params: types.DocumentOnTypeFormattingParams) -> list[types.TextEdit] | None:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return None
    offset = to_offset(document.lines, params.position, ls.editor.encoding)
    return _converted(ls, document, indent(document.analysis, offset))


def _converted(ls: Session, document: Document | RobotsFile, edits: Sequence[Edit]) -> list[types.TextEdit]:
    return [types.TextEdit(to_range(document.lines, edit.span, ls.editor.encoding), edit.text) for edit in edits]
