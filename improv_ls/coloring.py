"""Semantic tokens as LSP counts them: five numbers a word, each relative to the word before."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import chain
from typing import NamedTuple, TypeAlias

from improv_core.ide.semantic_tokens import colored, pieces
from improv_core.program.analysis import Analysis
from improv_core.syntax.parser import LONGEST_KEPT
from improv_core.text import LineIndex
from improv_ls.positions import Encoding, units

Chunk: TypeAlias = tuple[int, int, tuple[int, ...]]
"""The numbers of a statement or comment. Only the first two depend on where it stands: the rest is shared."""


class Coloring(NamedTuple):
    """What an editor has been told of a document, and under which name it will speak of that."""

    result_id: str
    chunks: Sequence[Chunk]


class Edit(NamedTuple):
    """Numbers to put in place of so many others, at a place in the old ones."""

    start: int
    delete_count: int
    data: Sequence[int]


def chunks(analysis: Analysis, encoding: Encoding, first: int = 0, last: int | None = None) -> list[Chunk]:
    """The numbers of all pieces that touch the text between two offsets."""
    found = []
    starts = analysis.lines.starts
    line = line_before = 0
    for start, text, unknown, strange in pieces(analysis, first, last):
        make = _kept if len(text) <= LONGEST_KEPT else _shape
        first_line, column, rest, last_line = make(text, unknown, strange, encoding)
        if not rest:
            continue
        while line + 1 < len(starts) and starts[line + 1] <= start:
            line += 1
        if start > starts[line] and not first_line:
            column += units(analysis.text[starts[line] : start], encoding)
        found.append((line + first_line - line_before, column, rest))
        line_before = line + last_line
    return found


def numbers(found: Sequence[Chunk]) -> list[int]:
    """All in one list, as the protocol wants them."""
    return list(chain.from_iterable((line, column, *rest) for line, column, rest in found))


def edits(old: Sequence[Chunk], new: Sequence[Chunk]) -> list[Edit]:
    """What makes the new numbers of the old ones, without what is alike."""
    begin, alike = _alike(old, new)
    old_end, new_end = len(old) - alike, len(new) - alike
    found = []
    start = sum(2 + len(rest) for _, _, rest in old[:begin])
    for one, other in _runs(old[begin:old_end], new[begin:new_end]):
        before, after = numbers(one), numbers(other)
        if before != after:
            found.append(_trimmed(start, before, after))
        start += len(before)
    return found


def _runs(old: Sequence[Chunk], new: Sequence[Chunk]) -> Iterator[tuple[Sequence[Chunk], Sequence[Chunk]]]:
    """Side by side where there are as many, so that what lies between two changes is not sent again."""
    if len(old) != len(new):
        yield old, new
        return
    for place in range(len(old)):
        yield old[place : place + 1], new[place : place + 1]


def _trimmed(start: int, old: Sequence[int], new: Sequence[int]) -> Edit:
    begin, alike = _alike(old, new)
    return Edit(start + begin, len(old) - begin - alike, new[begin : len(new) - alike])


def _alike(old: Sequence[object], new: Sequence[object]) -> tuple[int, int]:
    """How much of two is the same at their beginnings, and at their ends."""
    shorter = min(len(old), len(new))
    begin = next((place for place in range(shorter) if old[place] != new[place]), shorter)
    end = next((place for place in range(shorter - begin) if old[-1 - place] != new[-1 - place]), shorter - begin)
    return begin, end


class _Shape(NamedTuple):
    """A piece's numbers wherever it stands, and the lines and column, from its start, of its first and last word."""

    first_line: int
    column: int
    rest: tuple[int, ...]
    last_line: int


def _shape(text: str, unknown: tuple[str, ...], strange: tuple[str, ...], encoding: Encoding) -> _Shape:
    starts = LineIndex(text).starts
    last_line, plain = len(starts) - 1, text.isascii()
    found: list[int] = []
    line = place = 0
    for start, end, kind, modifiers in colored(text, unknown, strange):
        line_before = line
        while line < last_line and starts[line + 1] <= start:
            line += 1
            place = starts[line]
        # From the word before, in the same line.
        column, length = (
            (start - place, end - start)
            if plain
            else (units(text[place:start], encoding), units(text[start:end], encoding))
        )
        found += (line - line_before, column, length, kind, modifiers)
        place = start
    return _Shape(found[0], found[1], tuple(found[2:]), line) if found else _Shape(0, 0, (), 0)


_kept = lru_cache(maxsize=20_000)(_shape)
