"""Requests about the names in an open `improv.toml`."""

from __future__ import annotations

from collections.abc import Iterator

from lsprotocol import types

from improv_core.ide import rename as renaming
from improv_core.ide.references import Reference, plays
from improv_core.ide.robots_file import body_names
from improv_core.ide.robots_file import references as finding
from improv_core.ide.robots_file.references import FileSymbol, symbol_at
from improv_core.program.analysis import Analysis, analyze
from improv_core.robots.config import Robots, read_robots
from improv_core.text import Span
from improv_ls.documents import Document, RobotsFile, path_of
from improv_ls.positions import to_offset
from improv_ls.programs import programs_for
from improv_ls.session import Session
from improv_ls.to_lsp_locations import Changes, highlight, location


def definition(ls: Session, file: RobotsFile, params: types.DefinitionParams) -> list[types.Location]:
    """Return the lines that play a robot; for anything else, its declaration."""
    symbol = _symbol(ls, file, params.position)
    if symbol and symbol.section == "robots":
        return list(_plays(ls, file, symbol))
    return declaration(ls, file, params)


def declaration(
    ls: Session, file: RobotsFile, params: types.DeclarationParams | types.DefinitionParams
) -> list[types.Location]:
    """Return the section of a robot or a profile, or the table of a body part or a pose."""
    symbol = _symbol(ls, file, params.position)
    return _here(ls, file, finding.declarations(file.lines.text, symbol)[:1]) if symbol else []


def document_highlight(
    ls: Session, file: RobotsFile, params: types.DocumentHighlightParams
) -> list[types.DocumentHighlight]:
    """Return all occurrences of the name under the cursor in the file."""
    symbol, text = _symbol(ls, file, params.position), file.lines.text
    if not symbol:
        return []
    declared = [Reference(span, defines=True) for span in finding.declarations(text, symbol)]
    used = [Reference(span, defines=False) for span in finding.uses(text, symbol)]
    return [highlight(file.lines, each, ls.editor.encoding) for each in (*declared, *used)]


def references(ls: Session, file: RobotsFile, params: types.ReferenceParams) -> list[types.Location]:
    symbol, text = _symbol(ls, file, params.position), file.lines.text
    if not symbol:
        return []
    declared = finding.declarations(text, symbol) if params.context.include_declaration else []
    return [*_here(ls, file, [*declared, *finding.uses(text, symbol)]), *_plays(ls, file, symbol)]


def renamable(file: RobotsFile, offset: int) -> FileSymbol:
    """Return the symbol at an offset. Raises RefusalError if there is none that can be renamed."""
    symbol = symbol_at(file.lines.text, offset)
    if symbol and finding.declarations(file.lines.text, symbol):
        return symbol
    what = "robots, profiles, body parts, and poses"
    raise renaming.RefusalError(f"only {what} in this file can be renamed: put the cursor on one")


def rename(ls: Session, file: RobotsFile, offset: int, new: str) -> Changes:
    """Return the edits of the file, and of all programs that have a robot, a body part, or a pose. Raises
    RefusalError."""
    symbol, text = renamable(file, offset), file.lines.text
    if symbol.section == "profiles":
        return [(file, finding.rename_profile(text, symbol, new))]
    if symbol.section in ("body", "poses"):
        edits, renamed = body_names.rename_in_file(text, symbol, new)
        programs = _with_word(ls, file, symbol)
        used = [(each, body_names.rename_in_program(analysis, symbol, new, renamed)) for each, analysis in programs]
        return [(file, edits), *used]
    edits = renaming.rename_section(Robots(text=text), symbol.name, new)
    sharing = programs_for(ls.documents, path_of(file.uri), symbol.name)
    return [(file, edits), *((each, renaming.rename_robot(each.analysis, symbol.name, new)) for each in sharing)]


def _symbol(ls: Session, file: RobotsFile, position: types.Position) -> FileSymbol | None:
    return symbol_at(file.lines.text, to_offset(file.lines, position, ls.editor.encoding))


def _here(ls: Session, file: RobotsFile, spans: list[Span]) -> list[types.Location]:
    return [location(file, span, ls.editor.encoding) for span in spans]


def _plays(ls: Session, file: RobotsFile, symbol: FileSymbol) -> Iterator[types.Location]:
    """Yield the places where programs play a robot, or use a body part or a pose."""
    if symbol.section in ("body", "poses"):
        for program, analysis in _with_word(ls, file, symbol):
            for _, span in body_names.used_in(analysis, symbol):
                yield location(program, span, ls.editor.encoding)
    if symbol.section == "robots":
        for program in programs_for(ls.documents, path_of(file.uri), symbol.name):
            for _, span in plays(program.analysis, symbol.name):
                yield location(program, span, ls.editor.encoding)


def _with_word(ls: Session, file: RobotsFile, symbol: FileSymbol) -> Iterator[tuple[Document, Analysis]]:
    """Yield the programs that contain the word for a body part or a pose in the current file."""
    robots = read_robots(file.lines.text, path_of(file.uri))
    for program in programs_for(ls.documents, path_of(file.uri), symbol.name):
        yield program, analyze(program.analysis.text, robots)
