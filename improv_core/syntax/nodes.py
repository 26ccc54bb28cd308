"""The tree of a statement. Spans count from the start of the statement, so trees stay valid when statements move."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from improv_core.diagnostics import Diagnostic
from improv_core.score.movement import Movement
from improv_core.syntax.lexer import Token, lex
from improv_core.syntax.vocabulary import WORDS, Word
from improv_core.text import Span

LONGEST = 100_000
"""The most characters of a statement that is parsed: a bad paste must not freeze the editor."""


@dataclass(frozen=True, slots=True)
class Primitive:
    span: Span
    word: Word
    movement: Movement


@dataclass(frozen=True, slots=True)
class Name:
    span: Span
    text: str


@dataclass(frozen=True, slots=True)
class Missing:
    """A movement that is missing here. The parser has reported it."""

    span: Span


@dataclass(frozen=True, slots=True)
class Series:
    span: Span
    items: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Parallel:
    span: Span
    voices: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Bracket:
    """`( )`, or `[ ]`, which squeezes its items."""

    span: Span
    squeezes: bool
    body: Node | None


@dataclass(frozen=True, slots=True)
class Apply:
    """A transformer, its number or plane if it has one, and the term that it applies to."""

    span: Span
    word: Token
    argument: Token | None
    body: Node

    @property
    def plane(self) -> Word | None:
        return WORDS.get(self.argument.text) if self.argument else None


Node: TypeAlias = Primitive | Name | Missing | Series | Parallel | Bracket | Apply


@dataclass(frozen=True, slots=True)
class Statement:
    """A statement's tree and syntax errors.

    `sign` is the `beat`, `=`, or `$` that makes it a tempo, a definition, or a play statement; None if it has none.
    `heads` are the names before the sign. `body` is the movement, and `number` the tempo. `defines` is the name that
    it defines, if that name is allowed. `uses` are the names in the movement, each once. `has_voices` says whether it
    contains `||`.
    """

    text: str
    diagnostics: tuple[Diagnostic, ...]
    sign: Token | None
    heads: tuple[Token, ...] = ()
    body: Node | None = None
    number: Token | None = None
    defines: str | None = None
    uses: tuple[str, ...] = ()
    has_voices: bool = False

    @property
    def tokens(self) -> list[Token]:
        """All tokens, lexed again: many statements are kept, but few are asked for tokens. Empty if it is too long."""
        return lex(self.text) if len(self.text) <= LONGEST else []


def children(node: Node) -> tuple[Node, ...]:
    """The nodes directly inside."""
    if isinstance(node, Series):
        return node.items
    if isinstance(node, Parallel):
        return node.voices
    if isinstance(node, Apply):
        return (node.body,)
    if isinstance(node, Bracket) and node.body:
        return (node.body,)
    return ()


def nodes(node: Node) -> Iterator[Node]:
    """A node and all nodes inside it, in the order of the text."""
    yield node
    for child in children(node):
        yield from nodes(child)


def names(node: Node) -> Iterator[Name]:
    """The names inside a node, in the order of the text."""
    return (each for each in nodes(node) if isinstance(each, Name))


def items(voice: Node) -> int:
    """The number of items that a bracket counts in one of its voices."""
    return len(voice.items) if isinstance(voice, Series) else 1
