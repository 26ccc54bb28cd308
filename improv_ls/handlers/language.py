"""What a word is, and what may be written: each converts the position, asks the core, and converts the answer."""

from __future__ import annotations

from collections.abc import Sequence

from lsprotocol import types
from pygls.capabilities import get_capability

from improv_core.ide.completion import Item, complete, document
from improv_core.ide.hover import hover as hover_at
from improv_core.ide.signature_help import signature
from improv_ls import to_lsp
from improv_ls.positions import to_offset, to_range
from improv_ls.session import Session


def hover(ls: Session, params: types.HoverParams) -> types.Hover | None:
    opened = ls.documents.get(params.text_document.uri)
    if not opened:
        return None
    place = to_offset(opened.lines, params.position, ls.encoding)
    formats = get_capability(ls.client_capabilities, "text_document.hover.content_format")
    found = hover_at(opened.analysis, place, _pictures(ls, formats))
    if not found:
        return None
    return types.Hover(to_lsp.markup(found, formats), to_range(opened.lines, found.span, ls.encoding))


def completion(ls: Session, params: types.CompletionParams) -> types.CompletionList | None:
    opened = ls.documents.get(params.text_document.uri)
    found = complete(opened.analysis, to_offset(opened.lines, params.position, ls.encoding)) if opened else None
    if not opened or not found:
        return None
    # A blank asks only where there is little to choose from, so that lists don't come up between all words.
    if params.context and params.context.trigger_character == " " and {item.kind for item in found.items} != {"plane"}:
        return None
    snippets = get_capability(ls.client_capabilities, "text_document.completion.completion_item.snippet_support")
    return to_lsp.completion(opened, found, bool(snippets), ls.encoding)


def resolve(ls: Session, item: types.CompletionItem) -> types.CompletionItem:
    """The item with its documentation, which is made for the one that is looked at."""
    uri, statement, kind = item.data if isinstance(item.data, list) and len(item.data) == 3 else ("", 0, "")
    opened = ls.documents.get(uri)
    offered = Item(item.label, kind)
    option = "text_document.completion.completion_item.documentation_format"
    formats = get_capability(ls.client_capabilities, option)
    found = document(opened.analysis, offered, statement, _pictures(ls, formats)) if opened else None
    if found:
        item.documentation = to_lsp.markup(found, formats)
    return item


def signature_help(ls: Session, params: types.SignatureHelpParams) -> types.SignatureHelp | None:
    opened = ls.documents.get(params.text_document.uri)
    found = signature(opened.analysis, to_offset(opened.lines, params.position, ls.encoding)) if opened else None
    return to_lsp.signature(found) if found else None


def _pictures(ls: Session, formats: Sequence[str] | None) -> bool:
    """Whether to draw: plain text has no place for it."""
    return ls.settings.hover_pictures and types.MarkupKind.Markdown in (formats or ())
