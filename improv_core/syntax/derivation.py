"""Repair a sequence of terminals by the grammar, and list the terminals that may come next. Only this module uses lark.

It is used for statements with syntax errors. A repair depends only on the kinds of the tokens, and people make the same
few errors again and again. So repairs are cached and filled in with the actual tokens. lark is imported when the first
one is needed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from improv_core.slices import checkpoint

MAX_INSERTED = 2
"""The most missing terminals that may be inserted in a row: `fast ||` lacks a number and a movement."""
MAX_REPAIRS = 20
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


@dataclass(frozen=True, slots=True)
class Unexpected:
    """A token at index `at` (or the end) that does not fit, and the `wanted` terminals that would."""

    at: int
    wanted: frozenset[str]


@dataclass(frozen=True, slots=True)
class Repair:
    """The terminals of a correct statement, or none if there is no repair, and the first one that didn't fit."""

    leaves: tuple[Leaf, ...]
    unexpected: Unexpected | None


def repair(terminals: tuple[str, ...]) -> Repair:
    """Insert the terminals that a statement lacks, and skip those that don't fit. Never raises."""
    return _cached(terminals) if len(terminals) <= LONGEST_SHAPE else _repaired(terminals)


def prepare() -> None:
    """Load lark and the grammar, so that the first statement with an error doesn't wait for that: 0.1 s."""
    _lark()


def may_come_next(terminals: Sequence[str]) -> frozenset[str]:
    """The terminals that the grammar accepts after these. If these have errors, they are repaired first."""
    return frozenset(_Repairing(terminals).parser.accepts())


@cache
def _lark() -> Any:
    from lark import Lark
    from lark.lexer import Lexer

    class TokensAsTheyAre(Lexer):
        """Our lexer has already run, but lark requires one."""

        def __init__(self, lexer_conf: Any) -> None: ...

        def lex(self, lexer_state: Any, parser_state: Any) -> Any:
            return iter(())

    grammar = Path(__file__).with_name("grammar.lark").read_text(encoding="utf-8")
    return Lark(grammar, start="statement", parser="lalr", lexer=TokensAsTheyAre)


@lru_cache(maxsize=2_000)
def _cached(terminals: tuple[str, ...]) -> Repair:
    return _repaired(terminals)


def _repaired(terminals: Sequence[str]) -> Repair:
    repairing, end = _Repairing(terminals), len(terminals)
    while not repairing.feed(_leaf("$END", end)):
        if not repairing.insert(end):
            return Repair((), repairing.unexpected)
    return Repair(tuple(repairing.leaves[:-1]), repairing.unexpected)


class _Repairing:
    """A parser that has read terminals, and the `leaves` that it has accepted."""

    def __init__(self, terminals: Sequence[str]) -> None:
        self.parser = _lark().parse_interactive()
        self.leaves: list[Leaf] = []
        self.unexpected: Unexpected | None = None
        repairs = 0
        for at, kind in enumerate(terminals):
            checkpoint()
            is_hopeless = self.unexpected and kind in NEVER
            if not is_hopeless and not self.feed(_leaf(kind, at)) and repairs < MAX_REPAIRS:
                repairs += 1
                self._insert_before(_leaf(kind, at))

    def feed(self, leaf: Leaf) -> bool:
        """Read a leaf, and return whether it fits."""
        from lark import UnexpectedToken

        try:
            self.parser.feed_token(leaf)
        except UnexpectedToken:
            self.unexpected = self.unexpected or Unexpected(leaf.at, frozenset(self.parser.accepts()))
            return False
        self.leaves.append(leaf)
        return True

    def insert(self, at: int) -> bool:
        """Insert the one terminal that is missing here, and return whether there is one."""
        wanted = self.parser.accepts()
        kind = next((kind for kind in ("ELSE", "MISSING", "NUMBER", "PLANE", "SENSE") if kind in wanted), None)
        return kind is not None and self.feed(_leaf(kind, at, True))

    def _insert_before(self, leaf: Leaf) -> None:
        """Insert what is missing before a leaf that does not fit. If that does not help, skip the leaf."""
        parser, known = self.parser, len(self.leaves)
        self.parser = parser.copy(deepcopy_values=False)
        for _ in range(MAX_INSERTED):
            if not self.insert(leaf.at):
                break
            if leaf.type in self.parser.accepts():
                self.feed(leaf)
                return
        self.parser = parser
        del self.leaves[known:]
