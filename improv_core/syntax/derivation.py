"""Parse a sequence of terminals by the grammar, and list the terminals that may come next. Only this module uses lark.

It is used for statements with syntax errors. A derivation depends only on the kinds of the tokens, and people make the
same few errors again and again. So derivations are cached and filled in with the actual tokens. lark is imported when
the first one is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from improv_core.slices import checkpoint

MOST_INSERTED = 2
"""The most missing terminals that may be inserted in a row: `fast ||` lacks a number and a movement."""
MOST_REPAIRS = 20
"""After this many errors in a statement, tokens that don't fit are only skipped: repairs are slow, and only the first
error is reported."""
NEVER = frozenset({"STRAY", "DOLLAR", "EQUAL", "BEAT", "SCENE"})
"""Terminals that no movement contains. After the first error they are skipped without a trial."""
LONGEST_SHAPE = 1_000
"""The most terminals of a shape that is cached."""


class Leaf(NamedTuple):
    """A terminal: the token at index `at`, or if `inserted`, one that is missing before it."""

    type: str
    at: int
    inserted: bool = False


_leaf = lru_cache(maxsize=10_000)(Leaf)  # thousands of shapes share a few hundred


class Branch(NamedTuple):
    """A rule of the grammar and the parts that it matched."""

    rule: str
    parts: tuple[Shape, ...]


Shape: TypeAlias = Leaf | Branch


@dataclass(frozen=True, slots=True)
class Unexpected:
    """A token at index `at` (or the end) that does not fit, and the `wanted` terminals that would."""

    at: int
    wanted: frozenset[str]


@dataclass(frozen=True, slots=True)
class Derivation:
    """The tree of the terminals, and the first place where it had to be repaired."""

    statement: Branch | None
    unexpected: Unexpected | None


def derive(terminals: tuple[str, ...]) -> Derivation:
    """Parse the terminals of a statement. Never raises: missing terminals are inserted, and extra ones are skipped."""
    return _cached(terminals) if len(terminals) <= LONGEST_SHAPE else _derived(terminals)


def prepare() -> None:
    """Load lark and the grammar, so that the first statement with an error doesn't wait for that: 0.1 s."""
    _lark()
    _unexpected()


def may_come_next(terminals: Sequence[str]) -> frozenset[str]:
    """The terminals that the grammar accepts after these. If these have errors, they are repaired first."""
    parser, _ = _fed(terminals)
    return frozenset(parser.accepts())


@cache
def _lark() -> Any:
    from lark import Lark
    from lark.lexer import Lexer

    class TokensAsTheyAre(Lexer):
        """Our lexer has already run, but lark requires one."""

        def __init__(self, lexer_conf: Any) -> None: ...

        def lex(self, lexer_state: Any, parser_state: Any) -> Any:
            return iter(())

    class Branches:
        """lark calls this with the parts of each rule. So it builds branches directly, without a tree of its own."""

        def __getattr__(self, rule: str) -> Callable[[list[Shape]], Branch]:
            if rule.startswith("_") or not rule.islower():
                raise AttributeError(rule)  # a rule that lark makes for `+` and inlines again, or a terminal
            return lambda parts: Branch(rule, tuple(parts))

    grammar = Path(__file__).with_name("grammar.lark").read_text(encoding="utf-8")
    options = {"lexer": TokensAsTheyAre, "transformer": Branches(), "maybe_placeholders": False}
    return Lark(grammar, start="statement", parser="lalr", **options)


@cache
def _unexpected() -> type[Exception]:
    from lark import UnexpectedToken

    return UnexpectedToken


@lru_cache(maxsize=2_000)
def _cached(terminals: tuple[str, ...]) -> Derivation:
    return _derived(terminals)


def _derived(terminals: Sequence[str]) -> Derivation:
    parser, errors = _fed(terminals)
    end = len(terminals)
    while True:
        try:
            shape = parser.feed_token(_leaf("$END", end))
        except _unexpected():
            errors.append(Unexpected(end, frozenset(parser.accepts())))
            if not _insert(parser, end):
                return Derivation(None, errors[0])
        else:
            return Derivation(shape if isinstance(shape, Branch) else None, errors[0] if errors else None)


def _fed(terminals: Sequence[str]) -> tuple[Any, list[Unexpected]]:
    """A parser that has read these terminals, and the errors in them."""
    parser = _lark().parse_interactive()
    errors: list[Unexpected] = []
    for at, kind in enumerate(terminals):
        checkpoint()
        if errors and kind in NEVER:
            continue
        try:
            parser.feed_token(_leaf(kind, at))
        except _unexpected():
            if len(errors) < MOST_REPAIRS:
                errors.append(Unexpected(at, frozenset(parser.accepts())))
                _insert_before(parser, _leaf(kind, at))
    return parser, errors


def _insert_before(parser: Any, leaf: Leaf) -> None:
    """Insert what is missing before a leaf that does not fit. If that does not help, skip the leaf."""
    trial = parser.copy()
    for inserted in range(1, MOST_INSERTED + 1):
        if not _insert(trial, leaf.at):
            return
        if leaf.type in trial.accepts():
            for _ in range(inserted):
                _insert(parser, leaf.at)
            parser.feed_token(leaf)
            return


def _insert(parser: Any, at: int) -> bool:
    """Insert the one terminal that is missing here, if there is one."""
    wanted = parser.accepts()
    for kind in ("ELSE", "MISSING", "NUMBER", "PLANE", "SENSE"):
        if kind in wanted:
            parser.feed_token(_leaf(kind, at, True))
            return True
    return False
