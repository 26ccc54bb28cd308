"""Format an `improv.toml`: only spaces and empty lines change, and none inside strings, so it means the same."""

from __future__ import annotations

import re
from collections.abc import Iterator

from improv_core.diagnostics import Edit
from improv_core.robots.toml_positions import multi_line_strings
from improv_core.robots.toml_text import TomlText, read_toml
from improv_core.text import LINE_END, LineIndex, Span

_EQUALS = re.compile(r"[ \t]*=[ \t]*")


def format_file(text: str) -> list[Edit]:
    """Return the edits for the whole file, in the order of the text; none if it isn't valid TOML.

    One space stands on each side of `=`, one empty line above each section and the comment that belongs to it, at most
    one empty line elsewhere, and no space at the end of a line.
    """
    toml = read_toml(text)
    if toml.diagnostics:
        return []
    return sorted([*_equals(toml), *_lines(toml)], key=lambda edit: edit.span)


def format_span(text: str, span: Span) -> list[Edit]:
    """Return those edits that touch the lines of a selection."""
    lines = LineIndex(text)
    first, last = lines.start(lines.position(span.start).line), lines.end(lines.position(span.end).line)
    return [edit for edit in format_file(text) if first <= edit.span.start and edit.span.end <= last]


def _equals(toml: TomlText) -> Iterator[Edit]:
    for keys, entry in toml.positions.entries.items():
        between = Span(entry.key.end, entry.value.start)
        written = toml.text[slice(*between)]
        if isinstance(keys[-1], str) and _EQUALS.fullmatch(written) and written != " = ":
            yield Edit(between, " = ")


def _lines(toml: TomlText) -> Iterator[Edit]:
    text, lines = toml.text, LineIndex(toml.text)
    line_end = found[0] if (found := LINE_END.search(text)) else "\n"
    inside = _inside(lines)
    headers = {lines.position(span.start).line for span, _ in toml.positions.headers}
    above = {_first_comment(lines, header, inside) for header in headers}
    begun = False  # true once a line has text
    empty: list[int] = []  # the empty lines right above
    for number in range(len(lines.starts)):
        line, start, end = lines.line(number), lines.start(number), lines.end(number)
        if not line.strip(" \t") and number not in inside:
            empty.append(number)
            continue
        one = text[lines.end(empty[0]) : lines.start(empty[0] + 1)] if empty else line_end
        wanted = one if begun and (empty or number in above) else ""
        gap = Span(lines.start(empty[0]), start) if empty else Span(start, start)
        if text[slice(*gap)] != wanted:
            yield Edit(gap, wanted)
        begun, empty = True, []
        if number + 1 not in inside and line != line.rstrip(" \t"):
            yield Edit(Span(start + len(line.rstrip(" \t")), end), "")
    if begun:
        rest = Span(lines.start(empty[0]) if empty else len(text), len(text))
        wanted = "" if empty else line_end
        if text[slice(*rest)] != wanted:
            yield Edit(rest, wanted)


def _inside(lines: LineIndex) -> set[int]:
    """Return the lines that begin inside a string."""
    spans = multi_line_strings(lines.text)
    return {
        number
        for span in spans
        for number in range(lines.position(span.start).line + 1, lines.position(span.end).line + 1)
    }


def _first_comment(lines: LineIndex, header: int, inside: set[int]) -> int:
    """Return the first line of the comment right above a header, or the header's own."""
    while header and lines.line(header - 1).lstrip(" \t").startswith("#") and header - 1 not in inside:
        header -= 1
    return header
