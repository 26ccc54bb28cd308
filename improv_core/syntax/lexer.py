"""The tokens of a statement: words by their kind in the vocabulary, names, numbers, and signs. Never raises."""

from __future__ import annotations

import re
from sys import intern
from typing import NamedTuple

from improv_core.slices import checkpoint
from improv_core.syntax.characters import NAME, shape, spelled
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span

AT_ONCE = 1_000
"""Tokens between two places where lexing can be interrupted: less than a millisecond."""
NUMBER = r"[+-]?[0-9]*\.?[0-9]+"

_TOKEN = re.compile(
    rf"""[ \t\r\n\ufeff]*+ (?: \#[^\r\n]*+ [ \t\r\n\ufeff]*+)*+ (?:
        (?P<NAME> {NAME})
      | (?P<LPAR> \() | (?P<RPAR> \)) | (?P<LSQB> \[) | (?P<RSQB> \])
      | (?P<SCENE> -{{3,}})
      | (?P<NUMBER> {NUMBER})
      | (?P<OPERATOR> [*/])
      | (?P<BAR> \|\|) | (?P<EQUAL> =) | (?P<DOLLAR> \$)
      | (?P<END> \Z) | (?P<STRAY> .))""",
    re.VERBOSE | re.DOTALL,
)

_TERMINALS = {word.text: word.kind.value for word in WORDS.values()}


class Token(NamedTuple):
    """A token of a statement. `type` is its terminal in the grammar; offsets count from the start of the statement.

    `text` has the usual characters, where the statement may have others that mean the same.
    """

    type: str
    text: str
    start: int
    end: int

    @property
    def span(self) -> Span:
        return Span(self.start, self.end)


def lex(text: str) -> list[Token]:
    """Return the tokens of a text, without whitespace and comments. A character that fits none becomes a `STRAY`."""
    tokens = []
    is_plain = text.isascii()
    code = text if is_plain else shape(text)
    new = tuple.__new__  # takes a quarter of the time of Token's own constructor
    for match in _TOKEN.finditer(code):
        kind = match.lastgroup
        assert kind
        if kind == "END":
            break
        start, end = match.span(kind)
        piece = intern(code[start:end])
        if kind == "NAME":
            if not is_plain:
                piece = intern(spelled(text[start:end]))
            kind = _TERMINALS.get(piece, kind)
        tokens.append(new(Token, (kind, piece, start, end)))
        if not len(tokens) % AT_ONCE:
            checkpoint()
    return tokens
