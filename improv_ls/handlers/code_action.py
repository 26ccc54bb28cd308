"""textDocument/codeAction: fixes and refactorings."""

from __future__ import annotations

from lsprotocol import types

from improv_core.ide.code_action import Action, fixes
from improv_core.ide.code_action_refactor import refactorings
from improv_ls import to_lsp
from improv_ls.documents import Document
from improv_ls.positions import to_span
from improv_ls.session import Session
from improv_ls.to_lsp_locations import Changed, workspace_edit


def code_action(ls: Session, params: types.CodeActionParams) -> list[types.CodeAction]:
    document = ls.documents.get(params.text_document.uri)
    if not document:
        return []
    span = to_span(document.lines, params.range, ls.editor.encoding)
    only = [str(getattr(kind, "value", kind)) for kind in params.context.only or ()]
    found = [*fixes(document.analysis, span), *refactorings(document.analysis, span)]
    return [_converted(ls, document, action) for action in found if not only or _is_one_of(action.kind, only)]


def _is_one_of(kind: str, wanted: list[str]) -> bool:
    """Dots separate kinds: refactor.inline is a kind of refactor."""
    return any(f"{kind}.".startswith(f"{each}.") for each in wanted if each) or "" in wanted


def _converted(ls: Session, document: Document, action: Action) -> types.CodeAction:
    editor = ls.editor
    prefers = editor.can("text_document.code_action.is_preferred_support")
    changed = {document.uri: Changed(document.version, document.lines, action.edits)}
    fixed = [
        to_lsp.diagnostic(document.uri, document.lines, each, editor.encoding, editor.diagnostic_support)
        for each in action.diagnostics
    ]
    return types.CodeAction(
        title=action.title,
        kind=types.CodeActionKind(action.kind),
        diagnostics=fixed or None,
        is_preferred=(prefers and action.preferred) or None,
        edit=workspace_edit(changed, editor.takes_document_changes, editor.encoding),
    )
