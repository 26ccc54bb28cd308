"""What a program means and what is wrong with it: the one value that all editor features and the compiler read."""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from fractions import Fraction

from improv_core import movement
from improv_core.diagnostics import Diagnostic, Severity
from improv_core.movement import ENDLESS, SAME, Movement, all_by
from improv_core.syntax import nodes
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Node, Statement
from improv_core.syntax.parser import parse_statement
from improv_core.syntax.statements import split
from improv_core.syntax.vocabulary import WORDS, Kind, of_kind
from improv_core.text import LineIndex, Span

DEFAULT_TEMPO = Fraction(60)
LONGEST_NUMBER = 30
"""How many characters a number may have."""
MOST_BITS = 4096
"""How long the exact fractions of a movement may get: nested odd factors multiply."""
DEEPEST_VOICES = 200
"""How many levels of `||` may stand within `||` through names: each costs a level of recursion when walked."""

_ROBOT_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")


@dataclass(frozen=True, slots=True)
class Placed:
    """A statement and where it stands: its offset and its number in the document."""

    start: int
    index: int
    statement: Statement

    @property
    def span(self) -> Span:
        return Span(self.start, self.start + len(self.statement.text))


@dataclass(frozen=True, slots=True)
class Definition:
    """A name and the movement it stands for after statement `index`; `span` is the name where it is defined."""

    name: str
    span: Span
    index: int
    movement: Movement


@dataclass(frozen=True, slots=True)
class Analysis:
    """One version of a document, understood. `robots` maps each robot to what it plays, in order of appearance."""

    lines: LineIndex
    statements: tuple[Placed, ...]
    definitions: Mapping[str, Sequence[Definition]]
    tempo: Fraction
    robots: Mapping[str, Movement]
    diagnostics: tuple[Diagnostic, ...]

    @property
    def text(self) -> str:
        return self.lines.text

    @property
    def ok(self) -> bool:
        return all(diagnostic.severity is not Severity.ERROR for diagnostic in self.diagnostics)

    def statement_at(self, offset: int) -> Placed | None:
        """The statement that a cursor at `offset` touches."""
        index = bisect_right(self.statements, offset, key=lambda placed: placed.start) - 1
        placed = self.statements[index] if index >= 0 else None
        return placed if placed and placed.span.holds(offset) else None

    def definition(self, name: str, before: int) -> Definition | None:
        """What a name stands for in statement `before`."""
        return _latest(self.definitions.get(name, ()), before)

    def movement(self, placed: Placed, node: Node) -> Movement:
        """What a part of a statement means where it stands."""
        return _Reading(placed, self.definitions, self.lines, lambda diagnostic: None).movement(node)


def analyze(text: str) -> Analysis:
    """Read a whole program. Never raises; what is wrong is in `diagnostics`, in the order of the text."""
    lines = LineIndex(text)
    statements = tuple(Placed(start, index, parse_statement(piece)) for index, (start, piece) in enumerate(split(text)))
    diagnostics: list[Diagnostic] = []
    definitions: dict[str, list[Definition]] = {}
    later = _first_definitions(statements)
    plays: dict[str, list[Movement]] = {}
    tempo: Fraction | None = None
    first_beat: Placed | None = None
    for placed in statements:
        statement = placed.statement
        diagnostics += [diagnostic.shifted(placed.start) for diagnostic in statement.diagnostics]
        if not statement.sign:
            continue  # one mistake, one message: what it lacks has been said
        reading = _Reading(placed, definitions, lines, diagnostics.append, later)
        meaning = reading.movement(statement.body) if statement.body else movement.series(())
        if statement.sign.type == "BEAT":
            if first_beat:
                line = lines.position(first_beat.start).line + 1
                message = f"remove this `beat`: line {line} has one already"
                diagnostics.append(Diagnostic("duplicate-beat", placed.span, message))
                continue
            first_beat = placed
            tempo = reading.number(statement.number, "the tempo") if statement.number else None
        elif statement.sign.type == "EQUAL":
            for head in reading.names():
                known = definitions.setdefault(head.text, [])
                known.append(Definition(head.text, head.span.shifted(placed.start), placed.index, meaning))
        else:
            for robot in reading.robots():
                plays.setdefault(robot, []).append(meaning)
    return Analysis(
        lines,
        statements,
        definitions,
        tempo or DEFAULT_TEMPO,
        {robot: movement.series(parts) for robot, parts in plays.items()},
        tuple(sorted(diagnostics, key=lambda diagnostic: diagnostic.span)),
    )


def _first_definitions(statements: Sequence[Placed]) -> dict[str, Placed]:
    first: dict[str, Placed] = {}
    for placed in statements:
        if placed.statement.sign and placed.statement.sign.type == "EQUAL":
            for head in placed.statement.heads:
                first.setdefault(head.text, placed)
    return first


def _latest(definitions: Sequence[Definition], before: int) -> Definition | None:
    place = bisect_left(definitions, before, key=lambda definition: definition.index)
    return definitions[place - 1] if place else None


@dataclass(frozen=True, slots=True)
class _Reading:
    """Reads one statement in the scope it stands in, and reports what is wrong with it."""

    placed: Placed
    definitions: Mapping[str, Sequence[Definition]]
    lines: LineIndex
    report_to: Callable[[Diagnostic], None]
    later: Mapping[str, Placed] | None = None

    def report(self, code: str, span: Span, message: str) -> None:
        self.report_to(Diagnostic(code, span.shifted(self.placed.start), message))

    def names(self) -> Sequence[Token]:
        """The names this definition defines: one, or none if it can't be."""
        heads = [head for head in self.placed.statement.heads if head.text]
        return [head for head in heads if not self._reserved(head)]

    def robots(self) -> Sequence[str]:
        """The robots this statement is for, each once, without those that can't be."""
        robots: dict[str, None] = {}
        for head in self.placed.statement.heads:
            if not head.text or self._reserved(head):
                continue
            if not _ROBOT_NAME.fullmatch(head.text):
                message = f"`{head.text}` can't name a robot: use the letters a to z, digits and `_`, a letter first"
                self.report("bad-robot-name", head.span, message)
                continue
            robots[head.text] = None
        return list(robots)

    def _reserved(self, head: Token) -> bool:
        if head.text in WORDS:
            self.report("reserved-name", head.span, f"choose another name: `{head.text}` is a word of the language")
        return head.text in WORDS

    def number(self, token: Token, what: str) -> Fraction | None:
        """The exact value of a number above zero; None, reported, if it is not one."""
        if not token.text:
            return None
        if len(token.text) > LONGEST_NUMBER:
            self.report("bad-number", token.span, f"write {what} with at most {LONGEST_NUMBER} characters")
            return None
        try:
            above, _, below = token.text.partition("/")
            value = Fraction(above) / Fraction(below or 1)
        except ZeroDivisionError:
            self.report("bad-number", token.span, f"write {what} without dividing by 0")
            return None
        if value <= 0:
            self.report("bad-number", token.span, f"write {what} as a number above 0")
            return None
        return value

    def movement(self, node: Node) -> Movement:
        """The movement of a part of the statement; what is wrong with it counts as nothing at all."""
        made = self._made(node)
        length = 0 if made.duration == ENDLESS else movement.bits(Fraction(made.duration))
        if made.bits + length > MOST_BITS:
            span = node.argument.span if isinstance(node, nodes.Apply) and node.argument else node.span
            self.report("bad-number", span, "use simpler numbers: together they make a fraction too long to keep exact")
            return movement.series(())
        return made

    def _made(self, node: Node) -> Movement:
        if isinstance(node, nodes.Primitive):
            return movement.hold(node.word.velocity, span=node.span.shifted(self.placed.start))
        if isinstance(node, nodes.Name):
            return self._named(node)
        if isinstance(node, nodes.Series):
            return movement.series([self.movement(item) for item in node.items])
        if isinstance(node, nodes.Parallel):
            made = movement.parallel([self.movement(voice) for voice in node.voices])
            if made.depth > DEEPEST_VOICES:
                message = f"use fewer names within names: voices nest deeper than {DEEPEST_VOICES} levels here"
                self.report("too-deep", node.span, message)
                return movement.series(())
            return made
        if isinstance(node, nodes.Bracket):
            return self._bracketed(node)
        if isinstance(node, nodes.Apply):
            return self._applied(node)
        return movement.series(())

    def _named(self, node: nodes.Name) -> Movement:
        found = _latest(self.definitions.get(node.text, ()), self.placed.index)
        if found:
            return movement.use(found.movement, node.span.shifted(self.placed.start))
        if self.later is None:
            return movement.series(())
        if node.text in self.later:
            line = self.lines.position(self.later[node.text].start).line + 1
            message = f"move the definition of `{node.text}` (line {line}) above this line"
            if self.later[node.text].index == self.placed.index:
                message = f"define `{node.text}` above this line (line {line}) before using it in its own definition"
            self.report("used-before-definition", node.span, message)
        else:
            known = [*of_kind(Kind.PRIMITIVE, Kind.MIRROR, Kind.REPEAT, Kind.REFLECT, Kind.FACTOR), *self.definitions]
            near = get_close_matches(node.text, known, n=1) or get_close_matches(node.text.lower(), known, n=1)
            hint = f"did you mean `{near[0]}`?" if near else f"define it above: `{node.text} = …`"
            self.report("unknown-name", node.span, f"`{node.text}` is not known: {hint}")
        return movement.series(())

    def _bracketed(self, node: nodes.Bracket) -> Movement:
        if node.body is None:
            signs = "[]" if node.squeezes else "()"
            self.report("empty-group", node.span, f"write a movement in `{signs}`: it does nothing")
            return movement.series(())
        if not node.squeezes:
            return self.movement(node.body)
        voices = node.body.voices if isinstance(node.body, nodes.Parallel) else (node.body,)
        return movement.parallel([movement.pace(self.movement(voice), _items(voice)) for voice in voices])

    def _applied(self, node: nodes.Apply) -> Movement:
        body, word, argument = self.movement(node.body), node.word.text, node.argument
        if word in ("reverse", "retrograde"):
            if body.duration == ENDLESS:
                message = f"give the `repeat` inside a number: `{word}` can't begin at the end of what has none"
                self.report("endless-reverse", node.word.span, message)
                return movement.series(())
            backward = movement.reverse(body)
            return backward if word == "reverse" else movement.gain(backward, all_by(Fraction(-1)))
        if word == "repeat":
            return self._repeated(body, argument)
        if word == "reflect":
            return movement.gain(body, node.plane.velocity if node.plane else SAME)
        factor = self.number(argument, f"the number of `{word}`") if argument else None
        if factor is None:
            return body
        if word == "scale":
            return movement.gain(body, all_by(factor))
        return movement.pace(body, factor if word == "fast" else 1 / factor)

    def _repeated(self, body: Movement, argument: Token | None) -> Movement:
        if argument is None:
            return movement.repeat(body)
        if re.fullmatch("0+", argument.text):
            return movement.repeat(body, 0)
        count = self.number(argument, "the count of `repeat`")
        if count is None:
            return body
        if count.denominator != 1:
            self.report("bad-number", argument.span, "repeat a whole number of times: 0, 1, 2, …")
            return body
        return movement.repeat(body, int(count))


def _items(voice: Node) -> Fraction:
    return Fraction(len(voice.items) if isinstance(voice, nodes.Series) else 1)
