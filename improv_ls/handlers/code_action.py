"""textDocument/codeAction and codeAction/resolve: fixes, refactorings, and actions that play or stop."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from lsprotocol import types

from improv_core.diagnostics import Edit
from improv_core.ide.code_action import FIX_ALL, Action, fix_all, fixes
from improv_core.ide.code_action_play import PlayAction, play_actions, trials
from improv_core.ide.code_action_refactor import refactorings
from improv_core.ide.references import symbol_at
from improv_core.ide.rehearsal import Scenes
from improv_core.plain import message_without_links
from improv_core.robots.config import FILE_NAME, read_robots
from improv_core.robots.edits import add, place
from improv_core.text import Span, difference
from improv_ls.documents import AnyDocument, Document, RobotsFile, path_of, robots_file_now
from improv_ls.handlers.diagnostics import as_sent, diagnostics_of
from improv_ls.positions import to_range, to_scenes, to_span
from improv_ls.session import Session
from improv_ls.to_lsp_locations import workspace_edit

MAX_EDITS = 20
"""The most edits of an action that are sent before somebody chooses it, to editors that ask for the edits then."""


def code_action(ls: Session, document: AnyDocument, params: types.CodeActionParams) -> list[types.CodeAction]:
    span = to_span(document.lines, params.range, ls.editor.encoding)
    only = [str(getattr(kind, "value", kind)) for kind in params.context.only or ()]
    later = "edit" in (ls.editor.can("text_document.code_action.resolve_support.properties") or ())
    later = later and bool(ls.editor.can("text_document.code_action.data_support"))
    fixes_all = _is_one_of(FIX_ALL, only)
    edits = [
        _converted(ls, document, action, edited, span if later and len(action.edits) > MAX_EDITS else None)
        for action, edited in _actions(ls, document, span, fixes_all)
        if not only or _is_one_of(action.kind, only)
    ]
    if isinstance(document, RobotsFile):
        played = trials(document.lines.text, span)
    else:
        played = play_actions(document.analysis, span.start, *ls.performance.state.silenced)
    commands = [_command(each.title, each.command, _arguments(ls, document, each), each.kind) for each in played]
    if isinstance(document, Document) and (other := ls.performance.other_on_save):
        title = "Let saves continue the dance" if other == "continue" else "Let saves start the dance over"
        commands.append(_command(title, "onSave", [other]))
    resumes = ls.performance.playing.resumes.items()
    commands += [_command(f"Resume from this {name}", "resume", [beat]) for name, beat in resumes]
    return edits + [each for each in commands if not only or _is_one_of(str(each.kind), only)]


def resolve(ls: Session, action: types.CodeAction) -> types.CodeAction:
    """Add the edits to an action, for the current text; none if the action no longer exists there."""
    uri, start, end = action.data if isinstance(action.data, list) and len(action.data) == 3 else ("", 0, 0)
    if document := ls.documents.get(uri) or ls.robots_files.get(uri):
        for found, edited in _actions(ls, document, Span(start, end), action.kind == FIX_ALL):
            if (found.title, found.kind) == (action.title, action.kind):
                action.edit = _edit(ls, document, found, edited)
                break
    return action


def _actions(ls: Session, document: AnyDocument, span: Span, fixes_all: bool) -> Iterator[tuple[Action, AnyDocument]]:
    """Yield actions, and the document or file that each edits; the one that fixes all only if the client has asked for
    it by its kind."""
    if isinstance(document, RobotsFile):
        found = fixes(read_robots(document.lines.text, path_of(document.uri)).diagnostics, span)
    else:
        found = fixes(diagnostics_of(ls, document), span)
        if document.analysis.is_settled:  # a refactored program must keep its meaning
            found += refactorings(document.analysis, span)
        found += fix_all(document.analysis) if fixes_all else ()
    for action in found:
        yield action, document
    if isinstance(document, Document):
        yield from _additions(ls, document, span)
        yield from _listing(ls, document, span)


def _additions(ls: Session, document: Document, span: Span) -> Iterator[tuple[Action, RobotsFile]]:
    """Yield fixes that add a robot to `improv.toml`."""
    robots, text = document.analysis.config, document.analysis.text
    if not robots.path or not (file := robots_file_now(robots.path, ls.robots_files)):
        return
    for problem in document.analysis.diagnostics:
        if problem.code == "unknown-robot" and problem.span.start <= span.end and span.start <= problem.span.end:
            name = text[slice(*problem.span)]
            if not robots.role_of(name) and (edit := add(file.lines.text, name)):
                yield Action(f"Add {name} to improv.toml", "quickfix", (edit,), (problem,)), file


def _listing(ls: Session, document: Document, span: Span) -> Iterator[tuple[Action, RobotsFile]]:
    """Yield, for a robot, the action that lists all robots of the program in `improv.toml`, or in a new one, if it
    lists none."""
    config, program, symbol = document.analysis.config, path_of(document.uri), symbol_at(document.analysis, span.start)
    if not program or not symbol or symbol.kind != "robot" or config.robots:
        return
    creates = ls.editor.can("workspace.workspace_edit.resource_operations") or ()
    if not config.path and types.ResourceOperationKind.Create not in creates:
        return
    if not (file := robots_file_now(config.path or program.parent / FILE_NAME, ls.robots_files)):
        return
    text = place(file.lines.text, {}, document.analysis.robots)
    if text and text != file.lines.text:
        start, end, written = difference(file.lines.text, text)
        where = FILE_NAME if config.path else f"a new {FILE_NAME}"
        yield Action(f"List these robots in {where}", "refactor.rewrite", (Edit(Span(start, end), written),)), file


def _arguments(ls: Session, document: AnyDocument, action: PlayAction) -> list[Any]:
    arguments: list[Any] = [document.uri] if action.command in ("play", "only") else []
    if isinstance(action.only, Scenes):
        arguments.append(to_scenes(action.only))
    elif action.only:
        arguments.append(to_range(document.lines, action.only, ls.editor.encoding))
    return [*arguments, *([action.robot] if action.robot else [])]


def _command(title: str, name: str, arguments: list[Any], kind: str = "") -> types.CodeAction:
    title, name = message_without_links(title), f"improv.{name}"
    return types.CodeAction(title=title, kind=kind or name, command=types.Command(title, name, arguments=arguments))


def _is_one_of(kind: str, wanted: list[str]) -> bool:
    """Return whether one of the wanted kinds includes this one: dots separate kinds, so refactor.inline is a kind of
    refactor."""
    return any(f"{kind}.".startswith(f"{each}.") for each in wanted if each) or "" in wanted


def _converted(
    ls: Session, document: AnyDocument, action: Action, edited: AnyDocument, later: Span | None
) -> types.CodeAction:
    """Convert an action with its edits, or with the cursor's span if the editor asks for the edits later."""
    prefers = ls.editor.can("text_document.code_action.is_preferred_support")
    return types.CodeAction(
        title=action.title,
        kind=action.kind,
        diagnostics=as_sent(ls, document, action.diagnostics) or None,
        is_preferred=(prefers and action.preferred) or None,
        edit=None if later else _edit(ls, document, action, edited),
        data=[document.uri, *later] if later else None,
    )


def _edit(ls: Session, document: AnyDocument, action: Action, edited: AnyDocument) -> types.WorkspaceEdit:
    """Return the edits of an action. They may create an `improv.toml` for a program that has none."""
    exists = edited is document or not isinstance(document, Document) or document.analysis.config.path
    return workspace_edit([(edited, action.edits)], ls.editor, [] if exists else [edited.uri])
