"""Folding ranges: scenes, brackets over several lines, and comment blocks."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from improv_core.program.analysis import Analysis
from improv_core.slices import in_slices
from improv_core.syntax import nodes
from improv_core.syntax.characters import HASHES
from improv_core.text import LINE_END, LineIndex


@dataclass(frozen=True, slots=True)
class Fold:
    """Lines, counted from 0, that fold into the first. `kind` is code or comment."""

    first: int
    last: int
    kind: str = "code"


def folds(analysis: Analysis) -> list[Fold]:
    """Return all folds, at most one starting at each line, in the order of the text."""
    return widest([*comment_folds(analysis.lines), *_code(analysis), *_scenes(analysis)])


def widest(folds: Iterable[Fold]) -> list[Fold]:
    """Return the longest fold of those that start at the same line, in the order of the text."""
    found: dict[int, Fold] = {}
    for fold in folds:
        if fold.last > max(fold.first, found[fold.first].last if fold.first in found else 0):
            found[fold.first] = fold
    return [found[first] for first in sorted(found)]


def _code(analysis: Analysis) -> Iterator[Fold]:
    """Fold statements and brackets. A line that starts with the closing bracket stays visible."""
    lines = analysis.lines
    for start, statement in in_slices(zip(analysis.offsets, analysis.statements, strict=True)):
        if not LINE_END.search(statement.text):
            continue
        inside = nodes.nodes(statement.body) if statement.body else ()
        brackets = [node.span for node in inside if isinstance(node, nodes.Bracket)]
        for span in (*brackets, (0, len(statement.text))):
            first, last = (lines.position(start + place).line for place in span)
            yield Fold(first, last - 1 if lines.line(last).lstrip(" \t")[:1] in (")", "]") else last)


def _scenes(analysis: Analysis) -> Iterator[Fold]:
    """Fold from each `---` to the last line before the next one that is not blank."""
    lines, begin = analysis.lines, None
    marks = (lines.position(analysis.offsets[index]).line for index in analysis.scenes)
    for mark in (*marks, len(lines.starts)):
        last = mark - 1
        while begin is not None and last > begin and not lines.line(last).strip():
            last -= 1
        if begin is not None:
            yield Fold(begin, last)
        begin = mark


def comment_folds(lines: LineIndex) -> Iterator[Fold]:
    """Fold blocks of several comment lines."""
    begin: int | None = None
    for number in in_slices(range(len(lines.starts) + 1)):
        if lines.line(number).lstrip().startswith(tuple(HASHES)):
            begin = number if begin is None else begin
        elif begin is not None:
            yield Fold(begin, number - 1, "comment")
            begin = None
