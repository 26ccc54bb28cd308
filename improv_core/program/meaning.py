"""The meaning of one statement, given what its names stand for, and its errors."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from improv_core.diagnostics import Diagnostic, Severity, replace
from improv_core.program.unreachable import unperformed
from improv_core.score import movement
from improv_core.score.movement import ENDLESS, LARGEST, MOST_BITS, MOST_VOICES, SAME, Movement, all_by, is_too_fast
from improv_core.syntax import nodes
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Node, Statement
from improv_core.syntax.vocabulary import WORDS
from improv_core.text import Span

LONGEST_NUMBER = 30
"""The most characters of a number."""

NOTHING = movement.series(())
_ROBOT_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


@dataclass(frozen=True, slots=True, eq=False)
class Definition:
    """What a name stands for after the statement with this ID."""

    name: str
    statement: int
    movement: Movement


Scope = Mapping[str, Definition | None]
"""What each name in a statement stands for; None if nothing above the statement defines it."""


@dataclass(frozen=True, slots=True, eq=False)
class Meaning:
    """What a statement means in a scope. Spans count from the start of the statement.

    `unresolved` are the names that nothing above defines. Their messages depend on what is below.
    """

    scope: tuple[Definition | None, ...]
    movement: Movement
    diagnostics: tuple[Diagnostic, ...]
    unresolved: tuple[nodes.Name, ...] = ()
    tempo: Fraction | None = None
    definition: Definition | None = None
    robots: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether the statement itself has no error."""
        return not self.unresolved and all(each.severity is not Severity.ERROR for each in self.diagnostics)


def understand(statement: Statement, statement_id: int, scope: Scope) -> Meaning:
    """The meaning of the statement with this ID. Never raises."""
    diagnostics = list(statement.diagnostics)
    bound = tuple(scope.values())
    if not statement.sign:
        return Meaning(bound, NOTHING, tuple(diagnostics))  # already reported: one error, one message
    reader = _Reader(scope, diagnostics.append, {})
    meant, tempo, definition = NOTHING, None, None
    robots: tuple[str, ...] = ()
    if statement.body:
        meant = reader.movement(statement.body)
        if statement.has_voices or isinstance(meant.duration, float):  # otherwise all of it plays
            diagnostics += unperformed(statement.body, reader.movement_made)
    if statement.number:
        tempo = reader.number(statement.number, "the tempo")
    if statement.sign.type == "DOLLAR":
        robots = reader.robots(statement.heads)
    elif statement.sign.type == "EQUAL":
        for head in statement.heads:
            reader.is_reserved(head)
        definition = Definition(statement.defines, statement_id, meant) if statement.defines else None
    unresolved: tuple[nodes.Name, ...] = ()
    if statement.body and None in bound:
        unresolved = tuple(node for node in nodes.names(statement.body) if scope.get(node.text) is None)
    return Meaning(bound, meant, tuple(diagnostics), unresolved, tempo, definition, robots)


def movement_of(node: Node, scope: Scope) -> Movement:
    """The movement of a node of a statement, in its scope."""
    return _Reader(scope, lambda diagnostic: None, {}).movement(node)


@dataclass(frozen=True, slots=True)
class _Reader:
    """Reads the nodes of one statement, and reports what is wrong with them.

    `made` holds the movements of all nodes except primitives, by `id`.
    """

    scope: Scope
    report: Callable[[Diagnostic], None]
    made: dict[int, Movement]

    def movement(self, node: Node) -> Movement:
        """The movement of a node. A node with an error counts as an empty movement."""
        if isinstance(node, nodes.Primitive):
            return node.movement
        if isinstance(node, nodes.Name):
            found = self.scope.get(node.text)
            self.made[id(node)] = made = movement.use(found.movement, node.span, found.statement) if found else NOTHING
            return made
        made = self._made(node)
        if problem := _too_much(made):
            span = node.numbers[0].span if isinstance(node, nodes.Apply) and node.numbers else node.span
            self.report(Diagnostic("bad-number", span, problem))
            made = NOTHING
        self.made[id(node)] = made
        return made

    def movement_made(self, node: Node) -> Movement:
        """The movement of a node that has been read."""
        return node.movement if isinstance(node, nodes.Primitive) else self.made[id(node)]

    def robots(self, heads: Sequence[Token]) -> tuple[str, ...]:
        """The robots of a play statement, each once, without invalid names."""
        robots: dict[str, None] = {}
        for head in heads:
            if not head.text or self.is_reserved(head):
                continue
            if _ROBOT_NAME.fullmatch(head.text):
                robots[head.text] = None
                continue
            message = f"`{head.text}` is not a valid robot name: use a to z, digits, and `_`, starting with a letter"
            legal = re.sub(r"^[^A-Za-z]+|[^A-Za-z0-9_]", lambda match: "_" if match.start() else "", head.text)
            fixes = replace(f"Rename to {legal}", head.span, legal) if legal and legal not in WORDS else ()
            self.report(Diagnostic("bad-robot-name", head.span, message, fixes))
        return tuple(robots)

    def is_reserved(self, head: Token) -> bool:
        if head.text in WORDS:
            message = f"`{head.text}` is a reserved word: choose another name"
            fixes = replace(f"Rename to my_{head.text}", head.span, f"my_{head.text}")
            self.report(Diagnostic("reserved-name", head.span, message, fixes))
        return head.text in WORDS

    def number(self, token: nodes.Number, what: str) -> Fraction | None:
        """The exact value of a number above zero. Anything else is reported and gives None."""
        if not token.text:
            return None
        value = value_of(token.text)
        if isinstance(value, Fraction):
            return value
        self.report(Diagnostic("bad-number", token.span, f"write {what} {value}"))
        return None

    def _made(self, node: Node) -> Movement:
        if isinstance(node, nodes.Series):
            items = [self.movement(item) for item in node.items]
            if len(items) < FEW or _share_a_denominator(items):
                return movement.series(items)
            self.report(Diagnostic("bad-number", node.span, _TOO_LONG))
            return NOTHING
        if isinstance(node, nodes.Apply):
            return self._applied(node)
        if isinstance(node, nodes.Bracket):
            return self._bracketed(node)
        if isinstance(node, nodes.Parallel):
            return self._together(node.span, [self.movement(voice) for voice in node.voices])
        return NOTHING

    def _together(self, span: Span, voices: Sequence[Movement]) -> Movement:
        made = movement.parallel(voices)
        if made.width <= MOST_VOICES:
            return made
        message = f"{made.width:,} voices play at once here, and {MOST_VOICES} is the most: use fewer"
        self.report(Diagnostic("too-deep", span, message))
        return NOTHING

    def _bracketed(self, node: nodes.Bracket) -> Movement:
        if node.body is None:
            message = f"`{'[]' if node.squeezes else '()'}` is empty: write a movement in it or remove it"
            self.report(Diagnostic("empty-group", node.span, message, replace("Remove it", node.span, "")))
            return NOTHING
        if not node.squeezes:
            return self.movement(node.body)
        voices = node.body.voices if isinstance(node.body, nodes.Parallel) else (node.body,)
        paced = [movement.pace(self.movement(voice), Fraction(nodes.items(voice))) for voice in voices]
        made = self._together(node.span, paced)
        if made.duration not in (0, 1):
            long = "never ends" if made.duration == ENDLESS else f"takes {made.duration} beats, not one"
            self.report(Diagnostic("bracket-not-a-beat", node.span, f"this bracket {long}"))
        return made

    def _applied(self, node: nodes.Apply) -> Movement:
        body, word, argument = self.movement(node.body), node.word.text, (node.numbers[0] if node.numbers else None)
        if word in ("reverse", "retrograde"):
            if isinstance(body.duration, float):
                message = f"`{word}` needs a movement that ends: give the `repeat` in it a number"
                self.report(Diagnostic("endless-reverse", node.word.span, message))
                return NOTHING
            backward = movement.reverse(body)
            return backward if word == "reverse" else movement.gain(backward, all_by(Fraction(-1)))
        if word == "repeat":
            return self._repeated(body, argument)
        if word == "reflect":
            return movement.gain(body, node.plane.velocity if node.plane else SAME)
        factor = self.number(argument, f"the number after `{word}`") if argument else None
        if factor is None:
            return body
        if word == "scale":
            return movement.gain(body, all_by(factor))
        return movement.pace(body, factor if word == "fast" else 1 / factor)

    def _repeated(self, body: Movement, argument: nodes.Number | None) -> Movement:
        if argument is None:
            return movement.repeat(body)
        if not argument.text.strip("0") and argument.text:
            return movement.repeat(body, 0)
        count = self.number(argument, "the number after `repeat`")
        if count is None:
            return body
        if count.denominator != 1:
            message = "repeat a whole number of times: 0, 1, 2, …"
            self.report(Diagnostic("bad-number", argument.span, message))
            return body
        return movement.repeat(body, int(count))


FEW = 50
"""Up to this many fractions are added without checking their common denominator."""
_FEW_BITS = 150
"""A movement whose numbers have so few bits is neither too long nor too fast: its factors are below 2^300 together."""
_TOO_LONG = "these numbers make a fraction too long to compute exactly: use simpler ones"


def _too_much(made: Movement) -> str | None:
    """The message about numbers too long to stay exact or too large for a float; None if there are none.

    All code that converts a movement's numbers to floats relies on this check.
    """
    duration = made.duration
    length = made.bits if isinstance(duration, float) else made.bits + movement.bits(duration)
    if length <= _FEW_BITS:
        return None
    if LARGEST < duration < ENDLESS or is_too_fast(made.peak):
        return "these numbers make the movement too long or too fast to play: use smaller ones"
    return _TOO_LONG if length > MOST_BITS else None


def _share_a_denominator(items: Sequence[Movement]) -> bool:
    """Whether durations can be added exactly: the sum of thousands of unrelated fractions gets longer and longer."""
    common = 1
    for item in items:
        if isinstance(item.duration, Fraction):
            common = math.lcm(common, item.duration.denominator)
            if common.bit_length() > MOST_BITS:
                return False
    return True


@lru_cache(maxsize=1_000)
def value_of(text: str) -> Fraction | str:
    """The exact value of a number above zero, or words that say how to write one."""
    if len(text) > LONGEST_NUMBER:
        return f"with at most {LONGEST_NUMBER} characters"
    above, _, below = text.partition("/")
    if below and not Fraction(below):
        return "without dividing by 0"
    value = Fraction(above) / Fraction(below or 1)
    return value if value > 0 else "as a number above 0"
