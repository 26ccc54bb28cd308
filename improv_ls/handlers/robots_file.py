"""Requests about an open `improv.toml`. The handler of each method passes them on."""

from __future__ import annotations

from collections.abc import Iterator

from lsprotocol import types

from improv_core.ide import rename as renaming
from improv_core.ide.code_action import Action, fixes
from improv_core.ide.references import Reference, plays
from improv_core.ide.robots_file import body_names
from improv_core.ide.robots_file import completion as completing
from improv_core.ide.robots_file import hover as hovering
from improv_core.ide.robots_file import references as finding
from improv_core.ide.robots_file.references import FileSymbol, symbol_at
from improv_core.program.analysis import Analysis, analyze
from improv_core.robots.config import Robots, read_robots
from improv_core.text import Span
from improv_ls import to_lsp
from improv_ls.documents import Document, RobotsFile, path_of
from improv_ls.positions import to_offset, to_range
from improv_ls.session import Session
from improv_ls.sharing import programs_for
from improv_ls.to_lsp_locations import ChangedText, highlight, location


def completion(ls: Session, file: RobotsFile, params: types.CompletionParams) -> types.CompletionList | None:
    offset, text = to_offset(file.lines, params.position, ls.editor.encoding), file.lines.text
    asked_by = params.context.trigger_character if params.context else None
    found = completing.complete(text, offset, _robots_of(ls, file))
    if not found or (asked_by and {item.kind for item in found.items} != {"value"}):
        return None  # a list that pops up between all words is a nuisance
    snippets = ls.editor.can("text_document.completion.completion_item.snippet_support")
    return to_lsp.completion(file.uri, file.lines, found, bool(snippets), ls.editor.encoding)


def hover(ls: Session, file: RobotsFile, params: types.HoverParams) -> types.Hover | None:
    found = hovering.hover(file.lines.text, to_offset(file.lines, params.position, ls.editor.encoding))
    formats = ls.editor.can("text_document.hover.content_format")
    if not found:
        return None
    return types.Hover(to_lsp.markup(found, formats), to_range(file.lines, found.span, ls.editor.encoding))


def actions(file: RobotsFile, span: Span) -> list[Action]:
    return fixes(_robots(file).diagnostics, span)


def definition(ls: Session, file: RobotsFile, params: types.DefinitionParams) -> list[types.Location]:
    """Return the section of a profile; for a robot, the lines that play it."""
    symbol = _symbol(ls, file, params)
    if not symbol:
        return []
    if symbol.section == "robots":
        return list(_plays(ls, file, symbol))
    return _here(ls, file, finding.declarations(file.lines.text, symbol)[:1])


def declaration(ls: Session, file: RobotsFile, params: types.DeclarationParams) -> list[types.Location]:
    """Return the section of a robot or a profile, or the table of a body part or a pose."""
    symbol = _symbol(ls, file, params)
    return _here(ls, file, finding.declarations(file.lines.text, symbol)[:1]) if symbol else []


def highlights(ls: Session, file: RobotsFile, params: types.DocumentHighlightParams) -> list[types.DocumentHighlight]:
    """Return all occurrences of the name under the cursor in the file."""
    symbol, text = _symbol(ls, file, params), file.lines.text
    if not symbol:
        return []
    declared = [Reference(span, defines=True) for span in finding.declarations(text, symbol)]
    used = [Reference(span, defines=False) for span in finding.uses(text, symbol)]
    return [highlight(file.lines, each, ls.editor.encoding) for each in (*declared, *used)]


def references(ls: Session, file: RobotsFile, params: types.ReferenceParams) -> list[types.Location]:
    symbol, text = _symbol(ls, file, params), file.lines.text
    if not symbol:
        return []
    declared = finding.declarations(text, symbol) if params.context.include_declaration else []
    return [*_here(ls, file, [*declared, *finding.uses(text, symbol)]), *_plays(ls, file, symbol)]


def renamable(ls: Session, file: RobotsFile, params: types.PrepareRenameParams | types.RenameParams) -> FileSymbol:
    """Return the symbol at the cursor. Raises RefusalError if there is none that can be renamed."""
    symbol = _symbol(ls, file, params)
    if symbol and finding.declarations(file.lines.text, symbol):
        return symbol
    what = "robots, profiles, body parts, and poses"
    raise renaming.RefusalError(f"only {what} in this file can be renamed: put the cursor on one")


def rename(ls: Session, file: RobotsFile, params: types.RenameParams) -> dict[str, ChangedText]:
    """Return the edits of the file, and of all programs that have a robot, a body part, or a pose. Raises
    RefusalError."""
    symbol, text = renamable(ls, file, params), file.lines.text
    if symbol.section == "profiles":
        edits = finding.rename_profile(text, symbol, params.new_name)
        return {file.uri: ChangedText(file.version, file.lines, edits)}
    if symbol.section in ("body", "poses"):
        edits, renamed = body_names.rename_in_file(text, symbol, params.new_name)
        changed = {file.uri: ChangedText(file.version, file.lines, edits)}
        for program, analysis in _with_word(ls, file, symbol):
            edits = body_names.rename_in_program(analysis, symbol, params.new_name, renamed)
            changed[program.uri] = ChangedText(program.version, program.lines, edits)
        return changed
    edits = renaming.rename_section(Robots(text=text), symbol.name, params.new_name)
    changed = {file.uri: ChangedText(file.version, file.lines, edits)}
    for program in programs_for(ls.documents, path_of(file.uri), symbol.name):
        edits = renaming.rename_robot(program.analysis, symbol.name, params.new_name)
        changed[program.uri] = ChangedText(program.version, program.lines, edits)
    return changed


_Asked = (
    types.DefinitionParams
    | types.DeclarationParams
    | types.DocumentHighlightParams
    | types.ReferenceParams
    | types.PrepareRenameParams
    | types.RenameParams
)


def _symbol(ls: Session, file: RobotsFile, params: _Asked) -> FileSymbol | None:
    return symbol_at(file.lines.text, to_offset(file.lines, params.position, ls.editor.encoding))


def _here(ls: Session, file: RobotsFile, spans: list[Span]) -> list[types.Location]:
    return [location(file.uri, file.lines, span, ls.editor.encoding) for span in spans]


def _plays(ls: Session, file: RobotsFile, symbol: FileSymbol) -> Iterator[types.Location]:
    """Yield the places where programs play a robot, or use a body part or a pose."""
    if symbol.section in ("body", "poses"):
        for program, analysis in _with_word(ls, file, symbol):
            for _, span in body_names.used_in(analysis, symbol):
                yield location(program.uri, program.lines, span, ls.editor.encoding)
    if symbol.section == "robots":
        for program in programs_for(ls.documents, path_of(file.uri), symbol.name):
            for _, span in plays(program.analysis, symbol.name):
                yield location(program.uri, program.lines, span, ls.editor.encoding)


def _with_word(ls: Session, file: RobotsFile, symbol: FileSymbol) -> Iterator[tuple[Document, Analysis]]:
    """Yield the programs that contain the word for a body part or a pose in the current file."""
    robots = _robots(file)
    for program in programs_for(ls.documents, path_of(file.uri), symbol.name):
        yield program, analyze(program.analysis.text, robots)


def _robots_of(ls: Session, file: RobotsFile) -> list[str]:
    """Return the robots of the open programs that use the file."""
    path = path_of(file.uri)
    programs = (document for document in ls.documents.values() if document.analysis.config.path == path)
    return [robot for document in programs for robot in document.analysis.robots]


def _robots(file: RobotsFile) -> Robots:
    return read_robots(file.lines.text, path_of(file.uri))
