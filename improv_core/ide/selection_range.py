"""Selection ranges, to which a selection grows step by step: word, term, series, bracket, statement, document."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from improv_core.program.analysis import Analysis
from improv_core.program.program import Placed
from improv_core.slices import in_slices
from improv_core.syntax import nodes
from improv_core.syntax.characters import HASHES
from improv_core.syntax.lexer import Token
from improv_core.text import Span

_HASH = re.compile(rf"[{HASHES}]")
_WORD = re.compile(r"\w+")


def selections(analysis: Analysis, offset: int) -> list[Span]:
    """Return the spans around the cursor, from the innermost to the whole document, each larger than the one before."""
    return nested(analysis.text, [*_around(analysis, offset), *_in_comment(analysis, offset)])


def nested(text: str, spans: Iterable[Span]) -> list[Span]:
    """Return the whole text and those of the spans that lie in the one before, from the innermost on."""
    found = [Span(0, len(text))]
    for span in spans:
        last = found[-1]
        if span != last and span.start < span.end and last.start <= span.start and span.end <= last.end:
            found.append(span)
    return found[::-1]


def _around(analysis: Analysis, offset: int) -> Iterator[Span]:
    placed = analysis.statement_at(offset)
    if not placed:
        return
    yield placed.span
    token = _token(placed, offset - placed.start)
    if not token:
        return
    heads = placed.statement.heads
    if token in heads or any(head.span.start <= token.start and token.end <= head.span.end for head in heads):
        yield Span(heads[0].start, heads[-1].end).shifted(placed.start)
        yield from (head.span.shifted(placed.start) for head in heads if head.span.holds(token.start))
    elif placed.statement.opening and placed.statement.sign:
        first, *_ = after = [each for each in placed.statement.tokens if each.start >= placed.statement.sign.end]
        yield Span(first.start, after[-1].end).shifted(placed.start)
    elif body := placed.body:
        for node in in_slices(nodes.nodes(body)):
            if node.span.start <= token.start and token.end <= node.span.end:
                yield node.span.shifted(placed.start)
    yield token.span.shifted(placed.start)


def _token(placed: Placed, place: int) -> Token | None:
    """Return the token that the cursor touches. Between two, prefer a word to a sign, then the one after the cursor."""
    touching = [token for token in in_slices(placed.statement.tokens) if token.span.holds(place)]
    words = [token for token in touching if _WORD.match(token.text)]
    return next(iter((words or touching)[::-1]), None)


def _in_comment(analysis: Analysis, offset: int) -> Iterator[Span]:
    line, column = analysis.lines.position(offset)
    text, start = analysis.lines.line(line), offset - column
    comment = _HASH.search(text, 0, column + 1)
    if comment:
        yield Span(start + comment.start(), start + len(text))
        words = in_slices(_WORD.finditer(text, comment.start()))
        yield from (Span(*word.span()).shifted(start) for word in words if _touches(word, column))


def _touches(word: re.Match[str], column: int) -> bool:
    return word.start() <= column <= word.end()
