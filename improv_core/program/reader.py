"""Read trees as movements, and report errors of transformers, brackets, and uses of phrases."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache
from typing import Any

from improv_core.diagnostics import Diagnostic, replace
from improv_core.program import misuse
from improv_core.program.definitions import NOTHING, Definition, Expansion, Phrase, ReadNodes
from improv_core.program.measures import in_its_unit, unit_of, velocity_of
from improv_core.program.numbers import FEW, TOO_LONG, share_a_denominator, too_much
from improv_core.program.reporting import NOBODY, Argument, Fault, Given
from improv_core.score import algebra
from improv_core.score.by_part import by_part, to_pose
from improv_core.score.movement import (
    ENDLESS,
    MAX_DEPTH,
    MAX_VOICES,
    SAME,
    Movement,
)
from improv_core.score.reactions import Condition
from improv_core.slices import checkpoint
from improv_core.syntax import nodes
from improv_core.syntax.descent import DEEPEST
from improv_core.syntax.nodes import Bracket, Call, MeasuredWord, Name, Node, Number, Primitive
from improv_core.syntax.vocabulary import WORDS
from improv_core.syntax.word import Applied, Needs, Word
from improv_core.text import Span

MAX_EXPANDED = 10_000
"""The most pairs of a phrase and its arguments that one statement may need."""
MAX_READ = 100_000
"""The most nodes that one statement may read in bodies of phrases."""
AT_ONCE = 10
"""Nodes that are read between two checkpoints, in about a tenth of a millisecond."""
MAX_KNOWN = 1_000
"""The most expansions of one phrase that are cached for other statements."""


@dataclass(slots=True)
class Reading:
    """The state that all readers of one statement share.

    `robot` is the place of the robot that plays among the `robots` of the line, for `canon`. Once phrases need too
    much, `too_much` is a code and a message, and no more phrases are expanded. `read` counts the nodes that were read
    in bodies of phrases.
    """

    robot: int = 0
    robots: int = 0
    too_much: tuple[str, str] | None = None
    read: int = 0
    expansions: dict[tuple[object, ...], Expansion] = field(default_factory=dict)


@dataclass(slots=True, eq=False)
class Reader(ReadNodes):
    """Reads the nodes of one statement, or of a phrase with its arguments.

    `level` is the nesting level of the node being read, through phrases, and `deepest` the deepest level so far.
    `removable` are the empty brackets, by `id`, that can be removed: the statement can be read without them.
    """

    reading: Reading
    level: int = 0
    deepest: int = 0
    removable: set[int] = field(default_factory=set)

    def movement(self, node: Node) -> Movement:
        """Return the movement of a node. A node with an error counts as an empty movement."""
        if type(node) is Primitive:
            return node.movement
        if self.settled is not None and id(node) in self.settled.made:
            return self.settled.made[id(node)]
        if len(self.made) % AT_ONCE == AT_ONCE - 1:
            checkpoint()
        kind = type(node)
        if kind in _NOT_NESTED:
            made = _READ[kind](self, node)
        else:
            self.level += 1
            if self.level > self.deepest:
                self.deepest = self.level
            made = self._too_deep() if self.deepest > DEEPEST else _READ[kind](self, node)
            self.level -= 1
        if kind is not Name and ((made.bounds.open and made.bounds.depth > MAX_DEPTH) or too_much(made)):
            made = self._refused(node, made)
        self.made[id(node)] = made
        return made

    def _refused(self, node: Node, made: Movement) -> Movement:
        """Report a movement that is nested too deeply or has numbers that can't be played, and return an empty one."""
        if made.bounds.open and made.bounds.depth > MAX_DEPTH:
            message = f"movements that senses decide are nested more than {MAX_DEPTH} levels deep here: use fewer"
            self.report(Diagnostic("too-deep", node.span, message), node)
        elif problem := too_much(made):
            numbers = nodes.numbers(node) if isinstance(node, (nodes.Apply, MeasuredWord)) else ()
            span = numbers[0].span if numbers else node.span
            self.report(Diagnostic("bad-number", span, problem), node)
        return NOTHING

    def _too_deep(self) -> Movement:
        message = f"with the phrases in it, this is nested more than {DEEPEST} levels deep: use fewer"
        self.reading.too_much = ("too-deep", message)
        return NOTHING

    def _in_series(self, node: nodes.Series) -> Movement:
        for each in node.items:
            if type(each) is Bracket and not each.body:
                self.removable.add(id(each))
        items = [self.movement(item) for item in node.items]
        return algebra.series(items) if len(items) < FEW or self._add_up(node, items) else NOTHING

    def _chosen(self, node: nodes.Choice) -> Movement:
        then, otherwise = self._side(node.then), self._side(node.otherwise)
        make = WORDS[node.word.text].make
        assert make
        return make(
            Applied(then, node.word.start, node.word.end, condition=_condition(node.condition), otherwise=otherwise)
        )

    def _side(self, side: Node) -> Movement:
        """Return one side of an `if`. Only there do empty brackets have a meaning: to do nothing."""
        is_empty = isinstance(side, Bracket) and side.body is None
        if is_empty:
            self.made[id(side)] = NOTHING
        return NOTHING if is_empty else self.movement(side)

    def _named(self, name: Name) -> Movement:
        if argument := self.given.movements.get(name.text):
            self.deepest = max(self.deepest, self.level + argument.height)
            return algebra.from_statement(argument.movement, name.span, argument.statement)
        definition = self.scope.get(name.text)
        if not definition or definition.phrase or definition.takes:  # it lacks its arguments here
            return NOTHING
        return algebra.from_statement(definition.movement, name.span, definition.statement)

    def _called(self, call: Call) -> Movement:
        """Read a use of a phrase. Arguments that don't match its head are reported elsewhere."""
        definition = self.scope.get(call.name.text)
        self.movement(call.name)
        arguments = [self._argument(each) for each in call.movements]
        if not definition or not definition.phrase or not takes(definition.phrase, call):
            return NOTHING
        numbers = [value for value in self.numbers(call) if value is not None]
        if len(numbers) < len(call.numbers) or self.reading.too_much:
            return NOTHING
        expansion = self._expanded(definition, definition.phrase, numbers, arguments)
        self.deepest = max(self.deepest, self.level + expansion.height)
        if self.deepest > DEEPEST:
            self._too_deep()
        if self.reading.too_much:
            if self.given is NOBODY:
                code, message = self.reading.too_much
                self.report(Diagnostic(code, call.name.span, message), call)
            return NOTHING
        self.calls[id(call)] = expansion
        for fault in expansion.reader.faults:
            self._blame(call, definition.phrase, fault)
        return algebra.from_statement(expansion.movement, call.name.span, definition.statement)

    def _measured(self, node: MeasuredWord) -> Movement:
        """Return the movement of a word with measures. Those that are wrong wherever they stand don't count."""
        values = self.numbers(node)
        known = {
            id(each): in_its_unit(each, value)
            for each, value in zip(nodes.numbers(node), values, strict=True)
            if value is not None and unit_of(each)
        }
        measure, radius = known.get(id(node.measure)), known.get(id(node.radius))
        return algebra.hold(velocity_of(node.word, measure, radius), span=node.span)

    def _argument(self, node: Node) -> Argument:
        before, self.deepest = self.deepest, self.level
        made = self.movement(node)
        height = self.deepest - self.level
        self.deepest = max(before, self.deepest)
        passed_on = self.given.movements.get(node.text) if isinstance(node, Name) else None
        if passed_on:  # the same argument, wherever a parameter passes it on, is expanded once
            return passed_on
        return Argument(made, self.items(node), self.statement, height)

    def _expanded(
        self,
        definition: Definition,
        phrase: Phrase,
        numbers: Sequence[Fraction],
        arguments: Sequence[Argument],
    ) -> Expansion:
        """Return the expansion of a phrase with these arguments."""
        checkpoint()
        reading = self.reading
        key = (definition, *numbers, *(each.movement for each in arguments))
        known = reading.expansions.get(key) or (None if arguments else phrase.known.get(tuple(numbers)))
        if known:
            reading.expansions[key] = known
            return known
        if len(reading.expansions) >= MAX_EXPANDED:
            message = f"phrases within phrases need more than {MAX_EXPANDED:,} parts here: use fewer"
            reading.too_much = ("too-large", message)
        reading.read += phrase.size
        if reading.read > MAX_READ:
            message = f"the phrases used here have more than {MAX_READ:,} words together: use fewer or shorter ones"
            reading.too_much = ("too-large", message)
        named_numbers = {each.name: value for each, value in zip(phrase.numbers, numbers, strict=True)}
        named_movements = {each.name: argument for each, argument in zip(phrase.movements, arguments, strict=True)}
        given = Given(definition.name, named_numbers, named_movements)
        reader = Reader(
            phrase.scope,
            definition.statement,
            reading,
            settled=phrase.settled,
            given=given,
            level=self.level,
            deepest=self.level,
        )
        made = reader.movement(phrase.body)
        expansion = Expansion(reader, phrase.body, made, reader.deepest - self.level)
        reading.expansions[key] = expansion
        if not arguments and not reader.calls and not reading.too_much and len(phrase.known) < MAX_KNOWN:
            phrase.known[tuple(numbers)] = expansion
        return expansion

    def _blame(self, call: Call, phrase: Phrase, fault: Fault) -> None:
        """Report a fault of a phrase at the argument of this use that causes it."""
        given: Iterator[Node | Number] = iter((*call.numbers, *call.movements))
        causes = {each.name: argument for each, argument in zip(phrase.parameters, given, strict=True)}
        cause = causes.get(fault.parameter or "")
        if self.given is NOBODY:
            self.report(Diagnostic(fault.code, (cause or call.name).span, fault.message), cause or call)
        else:
            self.fault(Fault(fault.code, fault.message, self.culprit(fault.code, cause or call)))

    def _add_up(self, node: Node, items: Sequence[Movement]) -> bool:
        """Return whether the durations of items can be added exactly, and report if not."""
        if share_a_denominator(items):
            return True
        self.report(Diagnostic("bad-number", node.span, TOO_LONG), node)
        return False

    def _together(self, node: Node, voices: Sequence[Movement]) -> Movement:
        made = algebra.parallel(voices)
        if made.bounds.width > MAX_VOICES:
            message = f"{made.bounds.width:,} voices play at once here, and {MAX_VOICES} is the most: use fewer"
        elif made.bounds.depth > MAX_DEPTH:
            message = f"voices within voices are more than {MAX_DEPTH} deep here: use fewer"
        else:
            return made
        self.report(Diagnostic("too-deep", node.span, message), node)
        return NOTHING

    def _bracketed(self, node: Bracket) -> Movement:
        if node.body is None:
            message = f"`{'[]' if node.squeezes else '()'}` is empty: write a movement in it or remove it"
            fixes = replace("Remove it", node.span, "") if id(node) in self.removable else ()
            self.report(Diagnostic("empty-group", node.span, message, fixes), node)
            return NOTHING
        if not node.squeezes:
            return self.movement(node.body)
        paced = [algebra.pace(self.movement(each), _whole(nodes.items(each))) for each in nodes.voices(node.body)]
        made = self._together(node, paced)
        is_a_beat = made.open or made.duration in (0, 1)
        if not is_a_beat and all(self.scope.get(each.text, self) for each in nodes.names(node)):
            long = "never ends" if made.duration == ENDLESS else f"takes {made.duration} beats, not one"
            self.report(Diagnostic("bracket-not-a-beat", node.span, f"this bracket {long}"), node)
        return made

    def _applied(self, node: nodes.Apply) -> Movement:
        body = self.movement(node.body)
        word = WORDS[node.word.text]
        if (
            body.bounds.body.asked
            and body.body_words.has_poses
            and not (word.poses and (not node.plane or node.plane.poses))
        ):
            self.report(misuse.pose_reversed(node), node)
            return NOTHING
        if word.needs and not word.of_items and not self._is_enough(node, word, (body,)):
            return NOTHING
        numbers = [value for value in self.numbers(node) if value is not None] if node.numbers else ()
        if len(numbers) < len(node.numbers):
            return body
        if word.by_robot and (not self.reading.robots or self.given is not NOBODY):
            return body  # it stands in a definition, and that is reported
        items = self._items_of(node) if word.of_items else ()
        if items is None:
            return NOTHING
        it = Applied(
            body,
            node.word.start,
            node.word.end,
            numbers,
            not node.numbers or len(node.numbers[0].tokens) == 1,
            items,
            node.plane.gain if node.across and node.plane else SAME,
            _condition(node.condition) if node.condition else None,
            None,
            self.reading.robot,
            self.reading.robots,
        )
        if word.wrong and (wrong := word.wrong(it)):
            span = Span(node.numbers[0].span.start, node.numbers[-1].span.end)
            self.report(Diagnostic("bad-number", span, wrong), node)
            return body
        if word.needless and (needless := word.needless(it)):
            message = needless.replace("{written}", misuse.written(node))
            self.report(misuse.without_effect(node, message, safe=word.removable), node)
        if word.of_items and not self._is_enough(node, word, items):
            return NOTHING
        if body.bounds.open and (stalls := misuse.may_stall(node, body)):
            self.report(stalls, node)
        assert word.make
        return word.make(it)

    def _is_enough(self, node: nodes.Apply, word: Word, given: Sequence[Movement]) -> bool:
        """Return whether a word can apply to these movements, and report if not."""
        if word.needs and any(each.bounds.open for each in given):
            self.report(misuse.open_length(node, self.movement_made), node)
        elif word.needs is Needs.END and any(isinstance(each.duration, float) for each in given):
            self.report(misuse.endless(node, self.movement_made), node)
        elif word.is_even and len({each.duration for each in given}) > 1:
            self.report(misuse.uneven(node, items_written(node.body), given), node)
        else:
            return True
        return False

    def _items_of(self, node: nodes.Apply) -> Sequence[Movement] | None:
        """Return the items that a word applies to; None if their durations can't be added."""
        found = self.items(node.body)
        items = found.movements
        if found.statement != self.statement:
            span = nodes.inside_parentheses(node.body).span
            items = tuple([algebra.from_statement(item, span, found.statement) for item in items])
        return items if len(items) < FEW or self._add_up(node, items) else None


def takes(phrase: Phrase | None, call: Call) -> bool:
    """Return whether the arguments of a use match the head of a phrase in number."""
    if not phrase:
        return not call.numbers and not call.movements
    return len(call.numbers) == len(phrase.numbers) and len(call.movements) == len(phrase.movements)


def items_written(node: Node) -> Sequence[Node]:
    """Return the items of a movement, if they are written in the same place."""
    inside = nodes.inside_parentheses(node)
    return inside.items if isinstance(inside, nodes.Series) else ()


def _condition(condition: nodes.Condition) -> Condition:
    return Condition(condition.sense.text, not condition.is_negated)


_whole = lru_cache(maxsize=1_000)(Fraction)  # most brackets have few items, and share their rates
_NOT_NESTED = frozenset({nodes.Series, nodes.Parallel, MeasuredWord, Name})
_READ: Mapping[type[Node], Callable[[Reader, Any], Movement]] = {
    nodes.Series: Reader._in_series,
    nodes.Apply: Reader._applied,
    Bracket: Reader._bracketed,
    Name: Reader._named,
    nodes.Parallel: lambda reader, node: reader._together(node, [reader.movement(voice) for voice in node.voices]),
    Call: Reader._called,
    MeasuredWord: Reader._measured,
    nodes.PartTerm: lambda reader, node: by_part(reader.movement(node.body), node.name.text),
    nodes.PoseTerm: lambda _, node: to_pose(node.pose.text, node.span),
    nodes.Choice: Reader._chosen,
    nodes.Missing: lambda _, __: NOTHING,
}
"""The movement of each kind of node, except primitives."""
