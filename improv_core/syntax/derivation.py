"""How the grammar reads a sequence of terminals, and what it would accept. The only room that knows lark.

A derivation depends on the kinds of the tokens alone, and people write the same few shapes again and again: it is
kept, and read with other tokens the next time. lark is imported when the first statement is read, not before.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

MOST_MENDS = 2
"""How many things in a row may be put in: `fast ||` lacks a number and a movement."""
MOST_MISTAKES = 20
"""After so many in one statement, what does not fit is only left out: mending is slow, and only the first is told."""
NEVER = frozenset({"STRAY", "DOLLAR", "EQUAL", "BEAT"})
"""Terminals that no movement has: after a first mistake they need no trial."""
LONGEST_SHAPE = 1_000
"""How many terminals a shape that is kept may have."""


class Leaf(NamedTuple):
    """A terminal: the token at place `at`, or where `put_in`, one that is missing before it."""

    type: str
    at: int
    put_in: bool = False


_leaf = lru_cache(maxsize=10_000)(Leaf)  # thousands of shapes share a few hundred


class Branch(NamedTuple):
    """What a rule of the grammar has made of its parts."""

    rule: str
    parts: tuple[Shape, ...]


Shape: TypeAlias = Leaf | Branch


@dataclass(frozen=True, slots=True)
class Mistake:
    """The token at place `at` (behind the last: the end) does not fit; these terminals would."""

    at: int
    wanted: frozenset[str]


@dataclass(frozen=True, slots=True)
class Derivation:
    """What the grammar makes of the terminals, and where that had to be mended first."""

    statement: Branch | None
    mistake: Mistake | None


def derive(terminals: tuple[str, ...]) -> Derivation:
    """Read the terminals of a statement. Never raises: what is missing is put in, what is too much left out."""
    return _kept(terminals) if len(terminals) <= LONGEST_SHAPE else _derived(terminals)


def may_come_next(terminals: Sequence[str]) -> frozenset[str]:
    """The terminals that the grammar accepts behind these, which are mended first where they are wrong."""
    parser, _ = _fed(terminals)
    return frozenset(parser.accepts())


@cache
def _lark() -> Any:
    from lark import Lark
    from lark.lexer import Lexer

    class TokensAsTheyAre(Lexer):
        """Our lexer has done the work; lark only asks for one."""

        def __init__(self, lexer_conf: Any) -> None: ...

        def lex(self, lexer_state: Any, parser_state: Any) -> Any:
            return iter(())

    class Branches:
        """What lark calls with the parts of each rule; so it makes branches at once, and no tree of its own."""

        def __getattr__(self, rule: str) -> Callable[[list[Shape]], Branch]:
            if rule.startswith("_") or not rule.islower():
                raise AttributeError(rule)  # what lark makes of `+`, and takes apart again; a terminal
            return lambda parts: Branch(rule, tuple(parts))

    grammar = Path(__file__).with_name("grammar.lark").read_text(encoding="utf-8")
    options = {"lexer": TokensAsTheyAre, "transformer": Branches(), "maybe_placeholders": False}
    return Lark(grammar, start="statement", parser="lalr", **options)


@cache
def _unexpected() -> type[Exception]:
    from lark import UnexpectedToken

    return UnexpectedToken


@lru_cache(maxsize=2_000)
def _kept(terminals: tuple[str, ...]) -> Derivation:
    return _derived(terminals)


def _derived(terminals: Sequence[str]) -> Derivation:
    parser, mistakes = _fed(terminals)
    end = len(terminals)
    while True:
        try:
            shape = parser.feed_token(_leaf("$END", end))
        except _unexpected():
            mistakes.append(Mistake(end, frozenset(parser.accepts())))
            if not _mend(parser, end):
                return Derivation(None, mistakes[0])
        else:
            return Derivation(shape if isinstance(shape, Branch) else None, mistakes[0] if mistakes else None)


def _fed(terminals: Sequence[str]) -> tuple[Any, list[Mistake]]:
    """A parser that has read these terminals, and the mistakes in them."""
    parser = _lark().parse_interactive()
    mistakes: list[Mistake] = []
    for at, kind in enumerate(terminals):
        if mistakes and kind in NEVER:
            continue
        try:
            parser.feed_token(_leaf(kind, at))
        except _unexpected():
            if len(mistakes) < MOST_MISTAKES:
                mistakes.append(Mistake(at, frozenset(parser.accepts())))
                _mend_before(parser, _leaf(kind, at))
    return parser, mistakes


def _mend_before(parser: Any, leaf: Leaf) -> None:
    """Put in what is missing before a leaf that does not fit; if that does not help, the leaf is left out."""
    trial = parser.copy()
    for mends in range(1, MOST_MENDS + 1):
        if not _mend(trial, leaf.at):
            return
        if leaf.type in trial.accepts():
            for _ in range(mends):
                _mend(parser, leaf.at)
            parser.feed_token(leaf)
            return


def _mend(parser: Any, at: int) -> bool:
    """Put in the one thing that is missing here, if there is one."""
    wanted = parser.accepts()
    for kind in ("MISSING", "NUMBER", "PLANE"):
        if kind in wanted:
            parser.feed_token(_leaf(kind, at, True))
            return True
    return False
