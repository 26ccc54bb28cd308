"""The core's locations, symbols, ranges and edits as lsprotocol's types."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from lsprotocol import types

from improv_core.diagnostics import Edit
from improv_core.ide.document_symbol import OutlineEntry
from improv_core.ide.folding_range import Fold
from improv_core.ide.references import Reference
from improv_core.plain import message
from improv_core.slices import in_slices
from improv_core.text import LineIndex, Span
from improv_ls.documents import AnyDocument
from improv_ls.editor import Editor
from improv_ls.positions import Encoding, to_range

_KINDS = {
    "tempo": types.SymbolKind.Constant,
    "setting": types.SymbolKind.Constant,
    "name": types.SymbolKind.Variable,
    "phrase": types.SymbolKind.Function,
    "scene": types.SymbolKind.Namespace,
    "robot": types.SymbolKind.Class,
    "robots": types.SymbolKind.Class,
    "profile": types.SymbolKind.Interface,
    "section": types.SymbolKind.Module,
    "key": types.SymbolKind.Property,
}

_CLOSED = "closed"
"""The ID of the annotation of edits in files that aren't open."""
Changes: TypeAlias = Sequence[tuple[AnyDocument, Sequence[Edit]]]
"""The edits of documents and files."""


def location(document: AnyDocument, span: Span, encoding: Encoding) -> types.Location:
    return types.Location(document.uri, to_range(document.lines, span, encoding))


def highlight(lines: LineIndex, reference: Reference, encoding: Encoding) -> types.DocumentHighlight:
    kind = types.DocumentHighlightKind.Write if reference.defines else types.DocumentHighlightKind.Read
    return types.DocumentHighlight(to_range(lines, reference.span, encoding), kind)


def text_edits(document: AnyDocument, edits: Sequence[Edit], encoding: Encoding) -> list[types.TextEdit]:
    return [types.TextEdit(to_range(document.lines, edit.span, encoding), edit.text) for edit in in_slices(edits)]


def workspace_edit(
    changes: Changes, editor: Editor, new: Sequence[str] = (), *, asks: bool = False
) -> types.WorkspaceEdit:
    """Return edits for an editor, with the versions of documents if it takes versions, and of `new` files, which it
    must be able to create. With `asks`, an editor that can asks before it changes files that aren't open."""
    texts = [(each, text_edits(each, edits, editor.encoding)) for each, edits in changes if edits]
    closed = [each.uri for each, _ in texts if each.version is None]
    asks = bool(asks and closed and editor.can("workspace.workspace_edit.change_annotation_support"))
    if not editor.can("workspace.workspace_edit.document_changes") and not new:
        return types.WorkspaceEdit(changes={each.uri: edits for each, edits in texts})
    created = types.CreateFileOptions(ignore_if_exists=True)
    return types.WorkspaceEdit(
        document_changes=[
            *(types.CreateFile(uri, options=created) for uri in new),
            *(
                types.TextDocumentEdit(
                    types.OptionalVersionedTextDocumentIdentifier(each.uri, each.version),
                    [types.AnnotatedTextEdit(_CLOSED, edit.range, edit.new_text) for edit in edits]
                    if asks and each.version is None
                    else edits,
                )
                for each, edits in texts
            ),
        ],
        change_annotations={_CLOSED: types.ChangeAnnotation("Files that aren't open", True)} if asks else None,
    )


def document_symbol(lines: LineIndex, entry: OutlineEntry, encoding: Encoding) -> types.DocumentSymbol:
    return types.DocumentSymbol(
        name=message(entry.name),
        kind=_KINDS[entry.kind],
        range=to_range(lines, entry.span, encoding),
        selection_range=to_range(lines, entry.name_span, encoding),
        detail=entry.detail or None,
        children=[document_symbol(lines, part, encoding) for part in entry.parts] or None,
    )


def symbol_information(uri: str, lines: LineIndex, entry: OutlineEntry, encoding: Encoding) -> types.SymbolInformation:
    place = types.Location(uri, to_range(lines, entry.name_span, encoding))
    return types.SymbolInformation(place, message(entry.name), _KINDS[entry.kind])


def call_hierarchy_item(document: AnyDocument, entry: OutlineEntry, encoding: Encoding) -> types.CallHierarchyItem:
    return types.CallHierarchyItem(
        name=message(entry.name),
        kind=_KINDS[entry.kind],
        uri=document.uri,
        range=to_range(document.lines, entry.span, encoding),
        selection_range=to_range(document.lines, entry.name_span, encoding),
        detail=entry.detail or None,
    )


def folding_range(fold: Fold) -> types.FoldingRange:
    kind = types.FoldingRangeKind.Comment if fold.kind == "comment" else None
    return types.FoldingRange(fold.first, fold.last, kind=kind)


def selection_range(lines: LineIndex, spans: Sequence[Span], encoding: Encoding) -> types.SelectionRange:
    """Convert spans from the innermost out, each inside the next."""
    parent: types.SelectionRange | None = None
    for span in reversed(spans):
        parent = types.SelectionRange(to_range(lines, span, encoding), parent)
    assert parent, "the whole document is always among them"
    return parent
