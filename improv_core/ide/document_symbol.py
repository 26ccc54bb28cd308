"""The outline of a program: its scenes, its tempo, its names, and its robots' lines, with the length of each."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from improv_core.diagnostics import MAX_SHOWN
from improv_core.program.analysis import Analysis
from improv_core.program.opening import OPENING
from improv_core.program.program import Placed
from improv_core.program.timing import in_beats, moment
from improv_core.score.lengths import lengths
from improv_core.slices import checkpoint
from improv_core.syntax.nodes import Statement
from improv_core.syntax.parser import parse_statement
from improv_core.syntax.statements import split
from improv_core.text import Span


@dataclass(frozen=True, slots=True)
class OutlineEntry:
    """A line of the outline. `kind` is tempo, setting (the floor or the bar), name, phrase, robot, robots (several at
    once, which are its `parts`), or scene (its `parts` are the entries in it)."""

    name: str
    kind: str
    detail: str
    span: Span
    name_span: Span
    parts: tuple[OutlineEntry, ...] = ()


def outline(analysis: Analysis) -> list[OutlineEntry]:
    """Return the outline entries of a program, in the order of the text. It has only the first `MAX_SHOWN` lines with
    syntax errors: those after them aren't marked either, and tens of thousands would only fill the screen."""
    scenes: list[tuple[Placed | None, list[OutlineEntry]]] = [(None, [])]
    breaks, wrong = {*analysis.breaks}, 0
    for index, statement in enumerate(analysis.statements):
        checkpoint()
        wrong += bool(statement.diagnostics)
        if statement.kind == "SCENE":
            if index in breaks:
                scenes.append((analysis.placed(index), []))
            else:  # it names the first
                scenes[-1] = analysis.placed(index), scenes[-1][1]
        elif statement.diagnostics and wrong > MAX_SHOWN:
            continue
        elif entry := outline_of(analysis, index):
            scenes[-1][1].append(entry)
    named, first = scenes[0]
    if len(scenes) == 1 and not named:
        return first
    return [
        *([_scene(analysis, 1, named.span if named else first[0].name_span, first)] if first or named else []),
        *(_scene(analysis, number, line.span, parts) for number, (line, parts) in enumerate(scenes[1:], 2) if line),
    ]


def outline_of(analysis: Analysis, index: int) -> OutlineEntry | None:
    """Return the entry of one statement, except a scene; None if it has no name, robot, tempo, or setting."""
    statement, movement = analysis.statements[index], analysis.meanings[index].movement
    detail = in_beats(lengths(movement)) if statement.heads and not statement.parameters else ""
    return next(_entries(analysis.offsets[index], statement, detail), None)


def flattened(entries: Iterable[OutlineEntry]) -> Iterator[OutlineEntry]:
    """Yield the entries, with the parts of those that have parts in their place."""
    for entry in entries:
        yield from flattened(entry.parts) if entry.parts else (entry,)


def names_in(text: str) -> Iterator[OutlineEntry]:
    """Yield the names and robots of a program that is only searched. Computes no durations."""
    for start, piece in split(text):
        for entry in flattened(_entries(start, parse_statement(piece), "")):
            if entry.kind not in ("tempo", "setting"):
                yield entry


def _scene(analysis: Analysis, number: int, line: Span, parts: Sequence[OutlineEntry]) -> OutlineEntry:
    start, end = (parts[0].span.start, parts[-1].span.end) if parts else line
    name = analysis.scene_names[number - 1] if number <= len(analysis.scene_names) else ""
    span = Span(min(start, line.start), max(end, line.end))
    begin = analysis.scene_begin(number - 1)
    later = "" if begin and begin.is_fixed else " or later"
    detail = f"from {moment(float(begin.shortest))}{later}" if begin else "never performed"
    return OutlineEntry(name or f"scene {number}", "scene", detail if number > 1 else "", span, line, tuple(parts))


def _entries(start: int, statement: Statement, detail: str) -> Iterator[OutlineEntry]:
    sign, whole = statement.sign, Span(start, start + len(statement.text))
    if sign and sign.type == "BEAT":
        if statement.number and statement.number.text:
            yield OutlineEntry(f"beat {statement.number.text}", "tempo", "", whole, sign.span.shifted(start))
        return
    if sign and sign.type in OPENING:
        detail = _opening(statement)
        if sign.type in ("ROOM", "BAR_LENGTH") and detail:
            yield OutlineEntry(detail, "setting", "", whole, sign.span.shifted(start))
        if sign.type not in ("AT", "IS"):
            return
    kind = "robot"
    if sign and sign.type == "EQUAL":
        kind = "phrase" if statement.parameters else "name"
    heads = [head for head in statement.heads if head.text]
    each = [OutlineEntry(head.text, kind, detail, whole, head.span.shifted(start)) for head in heads]
    if len(each) < 2:
        yield from each
        return
    parts = tuple(OutlineEntry(part.name, kind, detail, part.name_span, part.name_span) for part in each)
    span = Span(parts[0].span.start, parts[-1].span.end)
    yield OutlineEntry(" ".join(part.name for part in parts), "robots", detail, whole, span, parts)


def _opening(statement: Statement) -> str:
    """Return the text of a line of the opening from its sign on; empty if it has an error."""
    tokens = statement.tokens
    if not statement.opening or not statement.sign or not tokens:
        return ""
    return " ".join(statement.text[statement.sign.start : tokens[-1].end].split())
