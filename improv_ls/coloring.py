"""Semantic tokens as LSP encodes them: five integers a token, its position relative to the token before."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import chain
from typing import NamedTuple, TypeAlias

from improv_core.ide.semantic_tokens import Uncolored, colored, fragments
from improv_core.program.analysis import Analysis
from improv_core.slices import in_slices
from improv_core.syntax.parser import LONGEST_KEPT
from improv_core.text import LineIndex
from improv_ls.positions import Encoding, units

Chunk: TypeAlias = tuple[int, int, tuple[int, ...]]
"""The integers of a statement or comment. Only the first two depend on its place: the rest is shared."""


class TokenEdit(NamedTuple):
    """Integers that replace `delete_count` of the old ones, from an index on."""

    start: int
    delete_count: int
    data: Sequence[int]


def chunks(analysis: Analysis, encoding: Encoding, first: int = 0, last: int | None = None) -> list[Chunk]:
    """Return all statements and comments that touch the text between two offsets."""
    found = []
    starts = analysis.lines.starts
    line = line_before = 0
    for start, fragment in in_slices(fragments(analysis, first, last)):
        make = _kept if len(fragment.text) <= LONGEST_KEPT else _shape
        first_line, column, rest, last_line = make(fragment, encoding)
        if not rest:
            continue
        while line + 1 < len(starts) and starts[line + 1] <= start:
            line += 1
        if start > starts[line] and not first_line:
            column += units(analysis.text[starts[line] : start], encoding)
        found.append((line + first_line - line_before, column, rest))
        line_before = line + last_line
    return found


def encoded(found: Sequence[Chunk]) -> list[int]:
    """Return all integers in one list, as LSP wants them."""
    return list(chain.from_iterable((line, column, *rest) for line, column, rest in found))


def edits(old: Sequence[Chunk], new: Sequence[Chunk]) -> list[TokenEdit]:
    """Return the edits that turn the old integers into the new ones."""
    begin, end = _common(old, new)
    old_end, new_end = len(old) - end, len(new) - end
    found = []
    start = sum(2 + len(rest) for _, _, rest in old[:begin])
    for one, other in _runs(old[begin:old_end], new[begin:new_end]):
        before, after = encoded(one), encoded(other)
        if before != after:
            begin, end = _common(before, after)
            found.append(TokenEdit(start + begin, len(before) - begin - end, after[begin : len(after) - end]))
        start += len(before)
    return found


def _runs(old: Sequence[Chunk], new: Sequence[Chunk]) -> Iterator[tuple[Sequence[Chunk], Sequence[Chunk]]]:
    """Pair the chunks one by one if there are as many, so that the part between two changes is not sent again."""
    if len(old) != len(new):
        yield old, new
        return
    for index in range(len(old)):
        yield old[index : index + 1], new[index : index + 1]


def _common(old: Sequence[object], new: Sequence[object]) -> tuple[int, int]:
    """Return the number of items that two sequences share at their beginnings, and at their ends."""
    shorter = min(len(old), len(new))
    begin = next((index for index in range(shorter) if old[index] != new[index]), shorter)
    end = next((index for index in range(shorter - begin) if old[-1 - index] != new[-1 - index]), shorter - begin)
    return begin, end


class _Shape(NamedTuple):
    """The integers of a statement or comment in any place; lines and columns count from its start."""

    first_line: int
    column: int
    rest: tuple[int, ...]
    last_line: int


def _shape(fragment: Uncolored, encoding: Encoding) -> _Shape:
    text = fragment.text
    starts = LineIndex(text).starts
    last_line, plain = len(starts) - 1, text.isascii()
    found: list[int] = []
    line = before = 0
    words = colored(fragment)
    if plain and not last_line:  # the usual case: a document that was just opened has thousands of words
        for start, end, kind, modifiers in in_slices(words):
            found += (0, start - before, end - start, kind, modifiers)
            before = start
        words = []
    for start, end, kind, modifiers in in_slices(words):
        line_before = line
        while line < last_line and starts[line + 1] <= start:
            line += 1
            before = starts[line]
        # Columns count from the token before, if it is in the same line.
        column, length = (
            (start - before, end - start)
            if plain
            else (units(text[before:start], encoding), units(text[start:end], encoding))
        )
        found += (line - line_before, column, length, kind, modifiers)
        before = start
    return _Shape(found[0], found[1], tuple(found[2:]), line) if found else _Shape(0, 0, (), 0)


_kept = lru_cache(maxsize=20_000)(_shape)
