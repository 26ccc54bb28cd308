"""How the grammar reads a sequence of terminals, and what it would accept. The only room that knows lark.

A derivation depends on the kinds of the tokens alone, and people write the same few shapes again and again: it is
kept, and read with other tokens the next time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.resources import files
from typing import Any, NamedTuple

from lark import Lark, Tree, UnexpectedToken
from lark.lexer import Lexer

MOST_MENDS = 2
"""How many things in a row may be put in: `fast ||` lacks a number and a movement."""


class Leaf(NamedTuple):
    """A terminal: the token at place `at`, or where `put_in`, one that is missing before it."""

    type: str
    at: int
    put_in: bool = False


@dataclass(frozen=True, slots=True)
class Mistake:
    """The token at place `at` (behind the last: the end) does not fit; these terminals would."""

    at: int
    wanted: frozenset[str]


@dataclass(frozen=True, slots=True)
class Derivation:
    """The tree that the grammar makes, with leaves at its ends, and what had to be mended for it."""

    tree: Tree[Leaf] | None
    mistakes: tuple[Mistake, ...]


@lru_cache(maxsize=10_000)
def derive(terminals: tuple[str, ...]) -> Derivation:
    """Read the terminals of a statement. Never raises: what is missing is put in, what is too much left out."""
    parser = _start()
    mistakes = [mistake for at, kind in enumerate(terminals) if (mistake := _feed(parser, Leaf(kind, at)))]
    end = len(terminals)
    while True:
        try:
            return Derivation(parser.feed_token(Leaf("$END", end)), tuple(mistakes))
        except UnexpectedToken:
            mistakes.append(Mistake(end, frozenset(parser.accepts())))
            if not _mend(parser, end):
                return Derivation(None, tuple(mistakes))


def may_come_next(terminals: Sequence[str]) -> frozenset[str]:
    """The terminals that the grammar accepts behind these, which are mended first where they are wrong."""
    parser = _start()
    for at, kind in enumerate(terminals):
        _feed(parser, Leaf(kind, at))
    return frozenset(parser.accepts())


class _TokensAsTheyAre(Lexer):
    """Our lexer has done the work; lark only asks for one."""

    def __init__(self, lexer_conf: Any) -> None: ...

    def lex(self, lexer_state: Any, parser_state: Any) -> Any:
        return iter(())


@cache
def _lark() -> Lark:
    grammar = files("improv_core.syntax").joinpath("grammar.lark").read_text(encoding="utf-8")
    return Lark(grammar, start="statement", parser="lalr", lexer=_TokensAsTheyAre)


def _start() -> Any:
    """An interactive parser (which lark leaves untyped), ready for the first terminal."""
    return _lark().parse_interactive()


def _feed(parser: Any, leaf: Leaf) -> Mistake | None:
    """Feed a leaf; where it does not fit, put in what is missing before it, or leave it out. None if it fitted."""
    try:
        parser.feed_token(leaf)
    except UnexpectedToken:
        mistake = Mistake(leaf.at, frozenset(parser.accepts()))
        trial = parser.copy()
        for mends in range(1, MOST_MENDS + 1):
            if not _mend(trial, leaf.at):
                break
            if leaf.type in trial.accepts():
                for _ in range(mends):
                    _mend(parser, leaf.at)
                parser.feed_token(leaf)
                break
        return mistake
    return None


def _mend(parser: Any, at: int) -> bool:
    """Put in the one thing that is missing here, if there is one."""
    wanted = parser.accepts()
    for kind in ("MISSING", "NUMBER", "PLANE"):
        if kind in wanted:
            parser.feed_token(Leaf(kind, at, put_in=True))
            return True
    return False
