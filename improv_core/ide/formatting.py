"""Format a program with edits so small that the cursor keeps its place."""

from __future__ import annotations

import re
from collections.abc import Iterator

from improv_core.diagnostics import Edit
from improv_core.ide.cursor import touching
from improv_core.program.analysis import LONGEST_PROGRAM, Analysis
from improv_core.slices import in_slices
from improv_core.syntax.characters import SPACES
from improv_core.syntax.formatter import edits
from improv_core.text import LINE_END, Span

_SPACES = re.compile(rf"[ \t\r\n\ufeff{SPACES}]*")


def format_all(analysis: Analysis) -> list[Edit]:
    """Return the edits for the whole program, which change only spaces and line ends; none if it is too long."""
    if len(analysis.text) > LONGEST_PROGRAM:
        return []
    return [small for edit in in_slices(edits(analysis.text)) for small in _small(analysis.text, edit)]


def format_span(analysis: Analysis, span: Span) -> list[Edit]:
    """Return the edits for all lines that a selection touches, extended to whole statements."""
    lines, text = analysis.lines, analysis.text
    touched = [each.span for each in touching(analysis, _lines(analysis, span))]
    start, end = _lines(analysis, Span(min([span.start, *(each.start for each in touched)]), span.end))
    end = max([end, *(lines.end(lines.position(each.end).line) for each in touched)])
    line_end = LINE_END.search(text)
    found: list[Edit] = []
    for edit in edits(text[start:end]):
        # These lines may not end the program, and the program may use other line ends than they do.
        put = edit.text.rstrip("\r\n") if edit.span.end == end - start else edit.text
        put = LINE_END.sub(line_end[0], put) if line_end else put
        found += _small(text, Edit(edit.span.shifted(start), put))
    return found


def _lines(analysis: Analysis, span: Span) -> Span:
    lines = analysis.lines
    return Span(lines.start(lines.position(span.start).line), lines.end(lines.position(span.end).line))


def _small(text: str, edit: Edit) -> Iterator[Edit]:
    """Split an edit into small parts, each between two words."""
    old, new = text[slice(*edit.span)], edit.text
    found, here, there = [], 0, 0
    while True:
        old_end, new_end = _end_of_spaces(old, here), _end_of_spaces(new, there)
        if old[here:old_end] != new[there:new_end]:
            found.append(Edit(Span(here, old_end).shifted(edit.span.start), new[there:new_end]))
        here, there = old_end, new_end
        if here == len(old) or there == len(new) or old[here] != new[there]:
            break
        here, there = here + 1, there + 1
    yield from found if here == len(old) and there == len(new) else [edit]


def _end_of_spaces(text: str, start: int) -> int:
    match = _SPACES.match(text, start)
    return match.end() if match else start
