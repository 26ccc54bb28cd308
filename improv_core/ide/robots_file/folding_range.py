"""Folding ranges of an `improv.toml`: sections, values over several lines, comment blocks, and regions."""

from __future__ import annotations

from collections.abc import Iterator

from improv_core.ide.folding_range import Fold, comment_folds, widest
from improv_core.ide.robots_file.sections import sections
from improv_core.robots.toml_positions import multi_line_strings
from improv_core.text import LineIndex


def folds(lines: LineIndex) -> list[Fold]:
    """Return all folds, at most one starting at each line, in the order of the text."""
    strings = [
        (lines.position(span.start).line, lines.position(span.end).line) for span in multi_line_strings(lines.text)
    ]
    outside = [
        fold
        for fold in comment_folds(lines)
        if not any(first < fold.first <= last or first < fold.last <= last for first, last in strings)
    ]
    return widest([*outside, *_code(lines)])


def _code(lines: LineIndex) -> Iterator[Fold]:
    """Fold sections and values. A line that starts with the closing bracket of a value stays visible."""
    for section in sections(lines.text):
        if section.header.start < section.header.end:
            yield Fold(lines.position(section.header.start).line, lines.position(section.span.end).line)
        for _, entry in section.values:
            first, last = (lines.position(place).line for place in (entry.key.start, entry.value.end))
            yield Fold(first, last - 1 if lines.line(last).lstrip(" \t")[:1] in ("]", "}") else last)
