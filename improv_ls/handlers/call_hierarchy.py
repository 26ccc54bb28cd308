"""textDocument/prepareCallHierarchy, callHierarchy/incomingCalls and callHierarchy/outgoingCalls."""

from __future__ import annotations

from collections.abc import Sequence

from lsprotocol import types

from improv_core.ide import call_hierarchy as hierarchy
from improv_ls.documents import Document
from improv_ls.positions import to_offset, to_range
from improv_ls.session import Session
from improv_ls.to_lsp_locations import call_hierarchy_item


def prepare(ls: Session, params: types.CallHierarchyPrepareParams) -> list[types.CallHierarchyItem]:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return []
    entry = hierarchy.prepare(document.analysis, to_offset(document.lines, params.position, ls.editor.encoding))
    return [call_hierarchy_item(document.uri, document.lines, entry, ls.editor.encoding)] if entry else []


def incoming(ls: Session, params: types.CallHierarchyIncomingCallsParams) -> list[types.CallHierarchyIncomingCall]:
    document = ls.documents.get(params.item.uri)
    if not document:
        return []
    calls = hierarchy.incoming(document.analysis, _place(ls, document, params.item))
    return [types.CallHierarchyIncomingCall(*_converted(ls, document, call)) for call in calls]


def outgoing(ls: Session, params: types.CallHierarchyOutgoingCallsParams) -> list[types.CallHierarchyOutgoingCall]:
    document = ls.documents.get(params.item.uri)
    if not document:
        return []
    calls = hierarchy.outgoing(document.analysis, _place(ls, document, params.item))
    return [types.CallHierarchyOutgoingCall(*_converted(ls, document, call)) for call in calls]


def _place(ls: Session, document: Document, item: types.CallHierarchyItem) -> int:
    """Return the offset of an item in the current text."""
    return to_offset(document.lines, item.selection_range.start, ls.editor.encoding)


def _converted(
    ls: Session, document: Document, call: hierarchy.HierarchyCall
) -> tuple[types.CallHierarchyItem, Sequence[types.Range]]:
    item = call_hierarchy_item(document.uri, document.lines, call.entry, ls.editor.encoding)
    return item, [to_range(document.lines, span, ls.editor.encoding) for span in call.spans]
