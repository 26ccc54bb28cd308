"""Spans and positions in a text. Offsets count code points; lines end at \\n, \\r\\n or \\r and nowhere else."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Callable, Container
from itertools import chain, count
from typing import NamedTuple, TypeVar

Items = TypeVar("Items", str, list[int])
LINE_END = re.compile(r"\r\n|\n|\r")


class Span(NamedTuple):
    """The text from `start` up to, not including, `end`."""

    start: int
    end: int

    def shifted(self, by: int) -> Span:
        return Span(self.start + by, self.end + by)

    def holds(self, offset: int) -> bool:
        """Return whether a cursor at `offset` touches the span. A cursor right before or after it counts."""
        return self.start <= offset <= self.end


class Position(NamedTuple):
    """A line and a column, both counted from 0; the column counts code points."""

    line: int
    column: int


class LineIndex:
    """The offsets at which the lines of a text start."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.starts = [0, *[end.end() for end in LINE_END.finditer(text)]]

    def edited(self, start: int, end: int, text: str) -> LineIndex:
        """Return the index after `text` has replaced the text from `start` to `end`."""
        whole = self.text[:start] + text + self.text[end:]
        # A \r before the edit or a \n after it may join with the new text.
        first = max(bisect_right(self.starts, start) - 2, 0)
        last = bisect_right(self.starts, end + 1)
        begin = self.starts[first]
        stop = self.starts[last] if last < len(self.starts) else len(self.text)
        growth = len(text) - (end - start)
        edited = LineIndex.__new__(LineIndex)
        edited.text = whole
        edited.starts = self.starts[: first + 1]
        edited.starts += [match.end() for match in LINE_END.finditer(whole, begin, stop + growth)]
        edited.starts += [offset + growth for offset in self.starts[last + 1 :]]
        return edited

    def position(self, offset: int) -> Position:
        """Return the position of an offset. An offset beyond the text counts as its end."""
        offset = min(max(offset, 0), len(self.text))
        line = bisect_right(self.starts, offset) - 1
        return Position(line, offset - self.starts[line])

    def ending(self, offset: int) -> str:
        """Return the line end of the line of an offset; that of the last line is the usual one."""
        line = self.position(offset).line
        return self.text[self.end(line) : self.start(line + 1)] or "\n"

    def number(self, offset: int) -> int:
        """Return the number of the line of an offset, counted from 1, as people do."""
        return self.position(offset).line + 1

    def whole(self, span: Span) -> Span:
        """Return all lines that a span touches, with their line ends."""
        return Span(self.start(self.position(span.start).line), self.start(self.position(span.end).line + 1))

    def line(self, number: int) -> str:
        """Return a line without its line end; empty if there is no such line."""
        return self.text[self.start(number) : self.end(number)]

    def start(self, number: int) -> int:
        """Return the offset at which a line starts. A line beyond the last one starts at the end of the text."""
        return self.starts[number] if number < len(self.starts) else len(self.text)

    def end(self, number: int) -> int:
        """Return the offset at which a line's text ends, before its line end."""
        if number + 1 >= len(self.starts):
            return len(self.text)
        end = self.starts[number + 1] - 1
        return end - 1 if self.text[end - 1 : end + 1] == "\r\n" else end


def free_name(name: str, taken: Container[str]) -> str:
    """Return a name that is not taken: this one, or else `name_2`, `name_3`, …"""
    names = chain([name], (f"{name}_{number}" for number in count(2)))
    return next(each for each in names if each not in taken)


def difference(before: Items, after: Items) -> tuple[int, int, Items]:
    """Return one edit that turns `before` into `after`: its start and end in `before`, and what is new."""
    shorter = min(len(before), len(after))
    start = _common(shorter, lambda length: before[:length] == after[:length])
    end = _common(shorter - start, lambda length: before[len(before) - length :] == after[len(after) - length :])
    return start, len(before) - end, after[start : len(after) - end]


def _common(most: int, holds: Callable[[int], bool]) -> int:
    """Find by bisection the largest length for which `holds` is true. It must be true for all smaller lengths."""
    least = 0
    while least < most:
        middle = (least + most + 1) // 2
        least, most = (middle, most) if holds(middle) else (least, middle - 1)
    return least


def has_in_order(text: str, letters: str) -> bool:
    """Return whether a text has these letters in this order, perhaps with others between them."""
    rest = iter(text)
    return all(letter in rest for letter in letters)
