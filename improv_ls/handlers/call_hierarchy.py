"""textDocument/prepareCallHierarchy, callHierarchy/incomingCalls and callHierarchy/outgoingCalls."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from lsprotocol import types

from improv_core.ide import call_hierarchy as hierarchy
from improv_core.program.analysis import Analysis
from improv_ls.documents import Document
from improv_ls.positions import to_offset, to_range
from improv_ls.session import Session
from improv_ls.to_lsp_locations import call_hierarchy_item


def prepare(ls: Session, document: Document, params: types.CallHierarchyPrepareParams) -> list[types.CallHierarchyItem]:
    entry = hierarchy.prepare(document.analysis, to_offset(document.lines, params.position, ls.editor.encoding))
    return [call_hierarchy_item(document, entry, ls.editor.encoding)] if entry else []


def incoming(
    ls: Session, document: Document, params: types.CallHierarchyIncomingCallsParams
) -> list[types.CallHierarchyIncomingCall]:
    return [types.CallHierarchyIncomingCall(*call) for call in _calls(ls, document, params.item, hierarchy.incoming)]


def outgoing(
    ls: Session, document: Document, params: types.CallHierarchyOutgoingCallsParams
) -> list[types.CallHierarchyOutgoingCall]:
    return [types.CallHierarchyOutgoingCall(*call) for call in _calls(ls, document, params.item, hierarchy.outgoing)]


def _calls(
    ls: Session,
    document: Document,
    item: types.CallHierarchyItem,
    find: Callable[[Analysis, int], Iterable[hierarchy.HierarchyCall]],
) -> Iterator[tuple[types.CallHierarchyItem, Sequence[types.Range]]]:
    """Yield the calls of an item, at its place in the current text."""
    lines, encoding = document.lines, ls.editor.encoding
    for call in find(document.analysis, to_offset(lines, item.selection_range.start, encoding)):
        ranges = [to_range(lines, span, encoding) for span in call.spans]
        yield call_hierarchy_item(document, call.entry, encoding), ranges
