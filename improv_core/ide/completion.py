"""What may be written at the cursor: decided by the grammar's state and by the names in scope."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass

from improv_core.analysis import Analysis
from improv_core.ide.timing import beats
from improv_core.syntax.derivation import may_come_next
from improv_core.syntax.lexer import Token, lex
from improv_core.syntax.statements import split
from improv_core.syntax.vocabulary import WORDS, Kind
from improv_core.text import Span

_MARK = "x"  # stands for the word being written, so that lexer and splitter see where it will be


@dataclass(frozen=True, slots=True)
class Item:
    """A word to offer: `kind` is keyword, movement, name, robot or plane; it replaces the text at `span`."""

    label: str
    kind: str
    detail: str
    span: Span


def complete(analysis: Analysis, offset: int) -> list[Item]:
    """The words that may stand at the cursor; none in comments and where only a number may come."""
    index = bisect_left(analysis.starts, offset)
    begin = analysis.starts[index - 1] if index else 0
    pieces = list(split(analysis.text[begin:offset] + _MARK))
    start, piece = pieces[-1] if pieces else (0, "")
    tokens = lex(piece)
    if not tokens or begin + start + tokens[-1].end != offset + len(_MARK):
        return []  # in a comment
    *before, last = tokens
    if before and before[-1].type == "NUMBER" and before[-1].end == last.start:
        return []  # in a number
    span = Span(offset - len(last.text) + len(_MARK), offset)
    current = index - 1 if start + begin == begin and index else index
    return [Item(label, kind, detail, span) for label, kind, detail in _words(analysis, before, current)]


def _words(analysis: Analysis, before: list[Token], index: int) -> Iterator[tuple[str, str, str]]:
    sign = next((place for place, token in enumerate(before) if token.type in ("EQUAL", "DOLLAR")), None)
    if sign is None:
        if not before:
            yield "beat", "keyword", WORDS["beat"].about
        if all(token.type == "NAME" for token in before):
            for robot, movement in analysis.robots.items():
                yield robot, "robot", beats(movement.duration)
        return
    accepted = may_come_next(["HEAD"] * sign + [token.type for token in before[sign:]])
    for word in WORDS.values():
        if word.kind.value in accepted and word.kind is not Kind.BEAT:
            kind = {Kind.PRIMITIVE: "movement", Kind.PLANE: "plane"}.get(word.kind, "keyword")
            yield word.text, kind, word.about
    if "NAME" in accepted:
        for name in analysis.defined:
            if found := analysis.definition(name, index):
                yield name, "name", beats(found.movement.duration)
