"""textDocument/formatting, rangeFormatting and onTypeFormatting."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.formatting import format_all, format_span
from improv_core.ide.on_type_formatting import indent
from improv_core.ide.robots_file import formatting as robots_file
from improv_ls.documents import AnyDocument, Document, RobotsFile
from improv_ls.positions import to_offset, to_span
from improv_ls.session import Session
from improv_ls.to_lsp_locations import text_edits


def formatting(ls: Session, document: AnyDocument, params: types.DocumentFormattingParams) -> list[types.TextEdit]:
    if isinstance(document, RobotsFile):
        return text_edits(document, robots_file.format_file(document.lines.text), ls.editor.encoding)
    return text_edits(document, format_all(document.analysis), ls.editor.encoding)


def range_formatting(
    ls: Session, document: AnyDocument, params: types.DocumentRangeFormattingParams
) -> list[types.TextEdit]:
    span = to_span(document.lines, params.range, ls.editor.encoding)
    if isinstance(document, RobotsFile):
        return text_edits(document, robots_file.format_span(document.lines.text, span), ls.editor.encoding)
    return text_edits(document, format_span(document.analysis, span), ls.editor.encoding)


def on_type_formatting(
    ls: Session, document: Document, params: types.DocumentOnTypeFormattingParams
) -> list[types.TextEdit]:
    offset = to_offset(document.lines, params.position, ls.editor.encoding)
    return text_edits(document, indent(document.analysis, offset), ls.editor.encoding)
