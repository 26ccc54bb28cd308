"""Which words are to be colored, and how: by what they are here, where a grammar only sees their form."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import TypeAlias

from improv_core.analysis import Analysis
from improv_core.ide.legend import MODIFIERS, TYPES
from improv_core.syntax.nodes import Statement
from improv_core.syntax.parser import parse_statement

_COMMENT = re.compile(r"#[^\r\n]*")


Colored: TypeAlias = tuple[int, int, int, int]
"""Where a word starts and ends, counted from the start of its piece; its type and its modifiers (a bit each) as the
legend's numbers."""

Piece: TypeAlias = tuple[int, str, tuple[str, ...], tuple[str, ...]]
"""The offset and the text of a statement or a line of comment, and the names and robots in it that are not known: they
get no color."""


def pieces(analysis: Analysis, first: int = 0, last: int | None = None) -> Iterator[Piece]:
    """The pieces of a program that touch the text between two offsets, in their order."""
    text, place = analysis.text, 0
    stop = len(text) if last is None else last
    suspects = analysis.wrong.union(analysis.casting)  # all others know all their names and robots
    for index, start in enumerate(analysis.starts):
        if text.find("#", place, start) >= 0:
            yield from _comment_lines(text, place, start, first, stop)
        if start > stop:
            return
        piece = analysis.statements[index].text
        place = start + len(piece)
        if place >= first:
            yield start, piece, *(_unknown(analysis, index) if index in suspects else ((), ()))
    yield from _comment_lines(text, place, len(text), first, stop)


def colored(text: str, unknown: tuple[str, ...], strange: tuple[str, ...]) -> list[Colored]:
    """The colored words of a piece, in its order: they depend on nothing else, so that they can be kept."""
    found = [(*comment.span(), *_COMMENT_KIND) for comment in _COMMENT.finditer(text)]
    if not text.startswith("#"):
        found += _words(parse_statement(text), unknown, strange)
    return sorted(found)


def _words(statement: Statement, unknown: tuple[str, ...], strange: tuple[str, ...]) -> Iterator[Colored]:
    sign = statement.sign
    heads = {head.span for head in statement.heads}
    for token in statement.tokens:
        kind = _KINDS.get(token.type)
        if token.type == "NAME" and sign and sign.type != "BEAT" and token.start < sign.start:
            if token.span in heads and token.text not in strange:  # not only a part of one, as in `my-robot`
                kind = _DEFINITION if sign.type == "EQUAL" else _ROBOT
        elif token.type == "NAME" and token.text not in unknown:
            kind = _USE
        if kind:
            yield token.start, token.end, *kind


def _unknown(analysis: Analysis, index: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The names and the robots of a statement that are not known."""
    statement, scope = analysis.statements[index], analysis.meanings[index].scope
    names = tuple(name for name, found in zip(statement.uses, scope, strict=True) if found is None)
    said = {each.span for each in analysis.casting.get(index, ()) if each.code == "unknown-robot"}
    return names, tuple(head.text for head in statement.heads if head.span in said)


def _comment_lines(text: str, start: int, end: int, first: int, last: int) -> Iterator[Piece]:
    for comment in _COMMENT.finditer(text, start, end):
        if comment.start() <= last and comment.end() >= first:
            yield comment.start(), comment.group(), (), ()


def _kind(name: str, *modifiers: str) -> tuple[int, int]:
    return TYPES.index(name), sum(1 << MODIFIERS.index(each) for each in modifiers)


_COMMENT_KIND = _kind("comment")
_DEFINITION = _kind("variable", "definition")
_USE = _kind("variable")
_ROBOT = _kind("class")
_KINDS: Mapping[str, tuple[int, int]] = {
    "BEAT": _kind("modifier"),
    "MIRROR": _kind("keyword"),
    "REPEAT": _kind("keyword"),
    "REFLECT": _kind("keyword"),
    "FACTOR": _kind("keyword"),
    "PRIMITIVE": _kind("function", "defaultLibrary"),
    "PLANE": _kind("enumMember"),
    "NUMBER": _kind("number"),
    "EQUAL": _kind("operator"),
    "DOLLAR": _kind("operator"),
    "BAR": _kind("operator"),
}
