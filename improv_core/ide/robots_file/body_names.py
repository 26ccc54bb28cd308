"""Find body parts and poses in programs, and rename them there and in `improv.toml`."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

from improv_core.diagnostics import Edit, applied
from improv_core.ide.body_words import takes
from improv_core.ide.phrases import poses_at
from improv_core.ide.references import names_used, performers
from improv_core.ide.rename import RefusalError
from improv_core.ide.robots_file.references import FileSymbol, declarations, section, uses
from improv_core.program.analysis import Analysis
from improv_core.robots.config import Robots, read_robots
from improv_core.robots.toml_text import read_toml
from improv_core.score.body import Body
from improv_core.text import Span


def declared(analysis: Analysis, offset: int, robots: Robots) -> Sequence[Span]:
    """Return the spans in `improv.toml` that declare the body part or the pose at the cursor, those of robots that
    perform the statement first."""
    placed = analysis.statement_at(offset)
    if not placed:
        return ()
    place, text = offset - placed.start, placed.statement.text
    symbols = {("poses", text[slice(*span)]) for span in poses_at(placed) if span.holds(place)}
    for name in names_used(placed):
        if name.span.holds(place) and takes(analysis, name.text, placed.index) is not None:
            symbols.add(("body", name.text))
    profiles = {profile.name for profile in performers(analysis, placed.index)} if symbols else ()
    entries = read_toml(robots.text).positions.entries if symbols else {}
    found = [(keys[1] not in profiles, entry.key) for keys, entry in entries.items() if section(keys) in symbols]
    return [span for _, span in sorted(found)]


def rename_in_file(text: str, symbol: FileSymbol, new: str) -> tuple[list[Edit], frozenset[str]]:
    """Return the edits of `improv.toml`, and the profiles that have the old word before them and lack it after them.

    Raises RefusalError.
    """
    before = read_robots(text)
    if not before.ok:
        raise RefusalError("improv.toml has an error: fix it first")
    if new == symbol.name:
        return [], frozenset()
    if _having(before, symbol.section, new):
        what = "body part" if symbol.section == "body" else "pose"
        raise RefusalError(f"`{new}` is already a {what}: choose another name")
    key = new if new.isascii() else f'"{new}"'
    edits = [Edit(span, key) for span in declarations(text, symbol)] + [Edit(span, new) for span in uses(text, symbol)]
    edits.sort(key=lambda each: each.span)
    after = read_robots(applied(text, edits))
    if not after.ok:
        raise RefusalError(after.diagnostics[0].message)
    lost = _having(before, symbol.section, symbol.name) - _having(after, symbol.section, symbol.name)
    return edits, frozenset(lost)


def rename_in_program(analysis: Analysis, symbol: FileSymbol, new: str, renamed: Collection[str]) -> list[Edit]:
    """Return the edits of a program whose robots have these renamed profiles. Raises RefusalError if robots of another
    profile perform the old word too, or if the program already uses the new one."""
    if new == symbol.name:
        return []
    edits = []
    for index, span in used_in(analysis, symbol):
        line = analysis.line_number(index)
        for profile in performers(analysis, index):
            if profile.name not in renamed and _has(profile.body, symbol.section, symbol.name):
                raise RefusalError(
                    f"on line {line}, `{symbol.name}` is also that of the profile {profile.name}: rename it by hand"
                )
        if symbol.section == "body" and any(each.name == new for each in analysis.statements[index].parameters):
            raise RefusalError(f"`{new}` is a parameter on line {line}: choose another name")
        edits.append(Edit(span, new))
    if edits and symbol.section == "body" and (taken := analysis.bindings.defined.get(new)):
        line = analysis.line_number(taken[0])
        raise RefusalError(f"`{new}` is already defined on line {line}: choose another name")
    return edits


def used_in(analysis: Analysis, symbol: FileSymbol) -> Iterator[tuple[int, Span]]:
    """Yield the uses of a body part or a pose of the file in a program: the index of the statement, and the span."""
    for index, statement in enumerate(analysis.statements):
        placed, found = analysis.placed(index), list[Span]()
        if symbol.section == "poses":
            found = [span for span in sorted(poses_at(placed)) if statement.text[slice(*span)] == symbol.name]
        elif analysis.bindings.definer(symbol.name, index) is None:
            found = [each.span for each in names_used(placed) if each.text == symbol.name]
        yield from ((index, span.shifted(placed.start)) for span in found)


def _having(robots: Robots, section: str, name: str) -> set[str]:
    return {profile.name for profile in robots.profiles.values() if _has(profile.body, section, name)}


def _has(body: Body | None, section: str, name: str) -> bool:
    return body is not None and name in (body.words if section == "body" else body.pose_names)
