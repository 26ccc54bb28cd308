"""The outline of a program: its tempo, its names, and what its robots play, with the length of each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from improv_core.program.analysis import Analysis
from improv_core.program.timing import in_beats
from improv_core.syntax.nodes import Statement
from improv_core.syntax.parser import parse_statement
from improv_core.syntax.statements import split
from improv_core.text import Span


@dataclass(frozen=True, slots=True)
class Entry:
    """A line of the outline. `kind` is tempo, name, robot, or robots (several at once, which are its `parts`)."""

    name: str
    kind: str
    detail: str
    span: Span
    name_span: Span
    parts: tuple[Entry, ...] = ()


def outline(analysis: Analysis) -> list[Entry]:
    """The outline entries of a program, in the order of the text."""
    found: list[Entry] = []
    for start, statement, meaning in zip(analysis.offsets, analysis.statements, analysis.meanings, strict=True):
        detail = in_beats(meaning.movement.duration) if statement.heads else ""
        found += _entries(start, statement, detail)
    return found


def names_in(text: str) -> Iterator[Entry]:
    """The names and robots of a program that is only searched. Computes no durations."""
    for start, piece in split(text):
        for entry in _entries(start, parse_statement(piece), ""):
            yield from entry.parts or ([entry] if entry.kind != "tempo" else [])


def _entries(start: int, statement: Statement, detail: str) -> Iterator[Entry]:
    sign, whole = statement.sign, Span(start, start + len(statement.text))
    if sign and sign.type == "BEAT":
        if statement.number and statement.number.text:
            yield Entry(f"beat {statement.number.text}", "tempo", "", whole, sign.span.shifted(start))
        return
    kind = "name" if sign and sign.type == "EQUAL" else "robot"
    heads = [head for head in statement.heads if head.text]
    each = [Entry(head.text, kind, detail, whole, head.span.shifted(start)) for head in heads]
    if len(each) < 2:
        yield from each
        return
    parts = tuple(Entry(part.name, kind, detail, part.name_span, part.name_span) for part in each)
    span = Span(parts[0].span.start, parts[-1].span.end)
    yield Entry(" ".join(part.name for part in parts), "robots", detail, whole, span, parts)
