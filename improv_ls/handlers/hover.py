"""textDocument/hover and signatureHelp."""

from __future__ import annotations

from collections.abc import Sequence

from lsprotocol import types

from improv_core.ide.hover import hover as hover_at
from improv_core.ide.robots_file import hover as robots_file
from improv_core.ide.signature_help import signature
from improv_ls import to_lsp
from improv_ls.documents import AnyDocument, Document, RobotsFile
from improv_ls.positions import to_offset, to_range
from improv_ls.session import Session


def hover(ls: Session, document: AnyDocument, params: types.HoverParams) -> types.Hover | None:
    offset = to_offset(document.lines, params.position, ls.editor.encoding)
    formats = ls.editor.can("text_document.hover.content_format")
    if isinstance(document, RobotsFile):
        found = robots_file.hover(document.lines.text, offset)
    else:
        found = hover_at(document.analysis, offset, shows_pictures(ls, formats))
    if not found:
        return None
    return types.Hover(to_lsp.markup(found, formats), to_range(document.lines, found.span, ls.editor.encoding))


def signature_help(ls: Session, document: Document, params: types.SignatureHelpParams) -> types.SignatureHelp | None:
    found = signature(document.analysis, to_offset(document.lines, params.position, ls.editor.encoding))
    return to_lsp.signature(found) if found else None


def shows_pictures(ls: Session, formats: Sequence[str] | None) -> bool:
    """Return whether hovers have pictures: plain text can't show any."""
    return ls.editor.settings.hover_pictures and types.MarkupKind.Markdown in (formats or ())
