"""Indent a line inside brackets as soon as it is started or closes a bracket."""

from __future__ import annotations

import re
from bisect import bisect_left

from improv_core.diagnostics import Edit
from improv_core.program.analysis import Analysis
from improv_core.syntax.formatter import INDENT
from improv_core.text import Span

_LEADING = re.compile(r"([ \t]*)([)\] \t]*)")


def indent(analysis: Analysis, offset: int) -> list[Edit]:
    """Return the edit that fixes a line's indentation, if only spaces and closing brackets come before the cursor.

    A line is indented as in the standard layout: by the number of brackets that are open at its start.
    """
    lines = analysis.lines
    number = lines.position(offset).line
    start, leading = lines.start(number), _LEADING.match(lines.line(number))
    index = bisect_left(analysis.offsets, start) - 1
    begun = analysis.offsets[index + 1 : index + 2]
    if not leading or offset > start + leading.end() or index < 0 or (begun and begun[0] <= lines.end(number)):
        return []
    placed = analysis.placed(index)
    first, last = lines.position(placed.start).line, lines.position(placed.span.end).line
    depth = 0
    for token in placed.statement.tokens:
        if placed.start + token.start < start:
            depth = max(depth + (token.text in "([") - (token.text in ")]"), 0)
    if not depth and not first < last == number - 1:
        return []  # it starts a new statement, which people may indent as they like
    margin = analysis.text[lines.start(first) : placed.start].replace("\ufeff", "")
    wanted = margin + INDENT * max(depth - sum(map(leading[2].count, ")]")), 0)
    return [Edit(Span(start, start + leading.end(1)), wanted)] if leading[1] != wanted else []
