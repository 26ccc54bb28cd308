"""The line of a program that a diagnostic is about, with carets under the place."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from itertools import accumulate

from improv_core.plain import printable
from improv_core.text import LineIndex, Span

TAB = "    "


def excerpt(lines: LineIndex, span: Span, room: int) -> tuple[str, str]:
    """Return the line on which a span starts, and carets under the part of the span on that line, for a terminal.

    A line wider than `room` cells is cut around the carets. Both are printable.
    """
    number, start = lines.position(span.start)
    line = lines.line(number)
    end = min(start + span.end - span.start, len(line))
    marked = _fitting(_shown(line[start : min(end, start + room)]), room * 3 // 4)
    spare = room - _cells(marked)
    after = _shown(line[end : end + spare]) if start + len(marked) == end else []
    before = _shown(line[max(start - spare, 0) : start])
    # The text after the carets gets at most half of the space, unless there is less text before them.
    left = _fitting(before[::-1], max(spare - _cells(after), spare // 2))[::-1]
    right = _fitting(after, spare - _cells(left))
    begin = "…" if len(left) < start else ""
    rest = "…" if start + len(marked) + len(right) < len(line) else ""
    shown = begin + "".join((*left, *marked, *right)) + rest
    return shown, " " * (len(begin) + _cells(left)) + "^" * max(_cells(marked), 1)


def _shown(text: str) -> list[str]:
    """Return each character in its printable form."""
    return [TAB if char == "\t" else printable(char) for char in text]


def _fitting(shown: Sequence[str], room: int) -> Sequence[str]:
    """Return the first characters: all that fit into this many cells."""
    count = sum(1 for width in accumulate(_widths(shown)) if width <= room)
    return shown[:count]


def _cells(shown: Iterable[str]) -> int:
    """Return the number of terminal cells that characters take."""
    return sum(_widths(shown))


def _widths(shown: Iterable[str]) -> Iterator[int]:
    return (sum(map(_width, each)) for each in shown)


def _width(char: str) -> int:
    """Return the cells of a printable character: East Asian characters and emoji take two, combining marks none."""
    if unicodedata.combining(char) or unicodedata.category(char) in ("Mn", "Me"):
        return 0
    return 2 if unicodedata.east_asian_width(char) in "WF" else 1
