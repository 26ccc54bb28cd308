"""textDocument/codeAction: fixes and refactorings."""

from __future__ import annotations

from collections.abc import Iterator

from lsprotocol import types
from pygls.uris import from_fs_path

from improv_core.diagnostics import Edit
from improv_core.ide.code_action import FIX_ALL, Action, fix_all, fixes
from improv_core.ide.code_action_refactor import refactorings
from improv_core.ide.references import symbol_at
from improv_core.robots.config import FILE_NAME
from improv_core.robots.edits import add, place
from improv_core.text import LineIndex, Span, difference
from improv_ls import to_lsp
from improv_ls.documents import Document, RobotsFile, path_of
from improv_ls.handlers import robots_file
from improv_ls.positions import to_span
from improv_ls.session import Session
from improv_ls.to_lsp_locations import Changed, workspace_edit


def code_action(ls: Session, params: types.CodeActionParams) -> list[types.CodeAction]:
    uri = params.text_document.uri
    document = ls.documents.get(uri) or ls.robots_files.get(uri)
    if not document:
        return []
    span = to_span(document.lines, params.range, ls.editor.encoding)
    only = [str(getattr(kind, "value", kind)) for kind in params.context.only or ()]
    return [
        _converted(ls, document, action, changed)
        for action, changed in _actions(ls, document, span, _is_one_of(FIX_ALL, only))
        if not only or _is_one_of(action.kind, only)
    ]


def _actions(
    ls: Session, document: Document | RobotsFile, span: Span, fixes_all: bool
) -> Iterator[tuple[Action, dict[str, Changed]]]:
    """Actions, and the edits of each; the one that fixes all only if the client has asked for it by its kind."""
    if isinstance(document, RobotsFile):
        found = robots_file.actions(document, span)
    else:
        found = [*fixes(document.analysis.diagnostics, span), *refactorings(document.analysis, span)]
        found += fix_all(document.analysis) if fixes_all else ()
    for action in found:
        yield action, {document.uri: Changed(document.version, document.lines, action.edits)}
    if isinstance(document, Document):
        yield from _additions(ls, document, span)
        yield from _listing(ls, document, span)


def _additions(ls: Session, document: Document, span: Span) -> Iterator[tuple[Action, dict[str, Changed]]]:
    """Fixes that add a robot to `improv.toml`."""
    robots, text = document.analysis.cast, document.analysis.text
    uri = from_fs_path(str(robots.path)) if robots.path else None
    if not uri:
        return
    file = ls.robots_files.get(uri) or RobotsFile(uri, None, LineIndex(robots.text))
    for problem in document.analysis.diagnostics:
        if problem.code == "unknown-robot" and problem.span.start <= span.end and span.start <= problem.span.end:
            name = text[slice(*problem.span)]
            if edit := add(file.lines.text, name):
                action = Action(f"Add {name} to improv.toml", "quickfix", (edit,), (problem,))
                yield action, {uri: Changed(file.version, file.lines, action.edits)}


def _listing(ls: Session, document: Document, span: Span) -> Iterator[tuple[Action, dict[str, Changed]]]:
    """On a robot, if `improv.toml` lists none: write all robots of the program into it, or into a new one."""
    cast, program, symbol = document.analysis.cast, path_of(document.uri), symbol_at(document.analysis, span.start)
    if not (program and symbol and symbol.is_robot) or cast.robots or not (cast.path or ls.editor.creates_files):
        return
    uri = from_fs_path(str(cast.path or program.parent / FILE_NAME)) or ""
    file = ls.robots_files.get(uri) or RobotsFile(uri, None, LineIndex(cast.text))
    text = place(file.lines.text, {}, document.analysis.robots)
    if text and text != file.lines.text:
        start, end, written = difference(file.lines.text, text)
        where = FILE_NAME if cast.path else f"a new {FILE_NAME}"
        action = Action(f"List these robots in {where}", "refactor.rewrite", (Edit(Span(start, end), written),))
        yield action, {uri: Changed(file.version, file.lines, action.edits)}


def _is_one_of(kind: str, wanted: list[str]) -> bool:
    """Dots separate kinds: refactor.inline is a kind of refactor."""
    return any(f"{kind}.".startswith(f"{each}.") for each in wanted if each) or "" in wanted


def _converted(
    ls: Session, document: Document | RobotsFile, action: Action, changed: dict[str, Changed]
) -> types.CodeAction:
    editor = ls.editor
    prefers = editor.can("text_document.code_action.is_preferred_support")
    fixed = [
        to_lsp.diagnostic(document.uri, document.lines, each, editor.encoding, editor.diagnostic_support)
        for each in action.diagnostics
    ]
    return types.CodeAction(
        title=action.title,
        kind=action.kind,
        diagnostics=fixed or None,
        is_preferred=(prefers and action.preferred) or None,
        edit=workspace_edit(changed, editor.takes_document_changes, editor.encoding, _new(document, changed)),
    )


def _new(document: Document | RobotsFile, changed: dict[str, Changed]) -> list[str]:
    """The files among those that change that do not exist yet: an `improv.toml`."""
    exists = isinstance(document, RobotsFile) or document.analysis.cast.path
    return [] if exists else [uri for uri in changed if uri != document.uri]
