"""Definitions of names, and of the words that need none: those for body parts, from profiles, and `to`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from fractions import Fraction
from functools import lru_cache

from improv_core.program.reporting import Items, Reporter
from improv_core.robots.config import Robots
from improv_core.score import algebra
from improv_core.score.movement import NOWHERE, Movement
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Call, Name, Node, Parameter
from improv_core.values import value

NOTHING = algebra.series(())
TO = "to"


@value(frozen=True, slots=True, eq=False)
class Phrase:
    """A phrase with parameters, as its uses need it. `settled` has read the nodes in the body that mention no
    parameter: they are the same in every use, and `size` counts the others. `known` are expansions that need no other
    phrases and no arguments except numbers."""

    parameters: tuple[Parameter, ...]
    body: Node
    scope: Scope
    settled: ReadNodes
    size: int
    known: dict[tuple[Fraction, ...], Expansion] = field(default_factory=dict)

    @property
    def numbers(self) -> Sequence[Parameter]:
        return [each for each in self.parameters if each.is_number]

    @property
    def movements(self) -> Sequence[Parameter]:
        return [each for each in self.parameters if not each.is_number]


class Takes(Enum):
    """The operand of a word that no statement defines: a term for a body part, or the name of a pose."""

    MOVEMENT = "movement"
    POSE = "POSE"


@value(frozen=True, slots=True, eq=False)
class Definition:
    """The meaning of a name after the statement with this ID.

    A phrase with parameters has no movement and no items until it is used, nor has a word that `takes` something.
    """

    name: str
    statement: int
    movement: Movement
    other_items: Items | None = None
    """Its items, if they aren't those that its movement has in this statement."""
    phrase: Phrase | None = None
    takes: Takes | None = None

    @property
    def items(self) -> Items:
        return self.other_items or Items(algebra.items_of(self.movement), self.statement)

    @property
    def head(self) -> str:
        """Return its usage: `poly n`, `times n (m)`, `head movement`."""
        if self.takes:
            return f"{self.name} {self.takes.value}"
        parameters = self.phrase.parameters if self.phrase else ()
        return " ".join([self.name, *(each.name if each.is_number else f"({each.name})" for each in parameters)])


Scope = Mapping[str, Definition | None]
"""The definition of each name in a statement; None if nothing above the statement defines it."""


@dataclass(slots=True, eq=False)
class ReadNodes(Reporter):
    """The nodes of one statement, or of a phrase with its arguments, that have been read.

    `made` holds the movements of all nodes except primitives, and `calls` the uses of phrases, by `id`. `settled` has
    the nodes that are the same in every use of a phrase.
    """

    scope: Scope
    statement: int
    settled: ReadNodes | None = field(default=None, kw_only=True)
    made: dict[int, Movement] = field(default_factory=dict, kw_only=True)
    calls: dict[int, Expansion] = field(default_factory=dict, kw_only=True)

    def movement_made(self, node: Node) -> Movement:
        """Return the movement of a node that was read. One that is nested too deeply to be read counts as empty."""
        if isinstance(node, nodes.Primitive):
            return node.movement
        return self.made.get(id(node)) or (self.settled.made.get(id(node)) if self.settled else None) or NOTHING

    def expansion(self, call: Call) -> Expansion | None:
        """Return the expansion of a use of a phrase that has been read; None if it is wrong."""
        return self.calls.get(id(call)) or (self.settled.calls.get(id(call)) if self.settled else None)

    def items(self, node: Node) -> Items:
        """Return the terms of a series that was read, through parentheses, names, and phrases."""
        node = nodes.inside_parentheses(node)
        if isinstance(node, nodes.Series):
            made = self.movement_made(node)
            if isinstance(made, algebra.Series) and len(made.items) == len(node.items):
                return Items(made.items, self.statement)
            return Items(tuple([self.movement_made(item) for item in node.items]), self.statement)
        if isinstance(node, Name):
            if argument := self.given.movements.get(node.text):
                return argument.items
            definition = self.scope.get(node.text)
            return definition.items if definition else Items((), self.statement)
        if isinstance(node, Call):
            expansion = self.expansion(node)
            return expansion.reader.items(expansion.body) if expansion else Items((), self.statement)
        if isinstance(node, nodes.Bracket) and not node.body:
            return Items((), self.statement)
        return Items((self.movement_made(node),), self.statement)


@value(frozen=True, slots=True, eq=False)
class Expansion:
    """The meaning of a phrase with these arguments. `height` is the number of its nested levels."""

    reader: ReadNodes
    body: Node
    movement: Movement
    height: int


def predefined(robots: Robots) -> Mapping[str, Definition]:
    """Return the definitions of these words, which apply if nothing above defines them."""
    return _predefined(robots.part_words)


@lru_cache(maxsize=100)
def _predefined(parts: frozenset[str]) -> Mapping[str, Definition]:
    return {TO: _word(TO, Takes.POSE), **{name: _word(name, Takes.MOVEMENT) for name in sorted(parts)}}


@lru_cache(maxsize=1_000)  # the same word has the same definition, so its uses keep their meanings
def _word(name: str, takes: Takes) -> Definition:
    return Definition(name, NOWHERE, NOTHING, takes=takes)
