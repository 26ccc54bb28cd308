"""Reads trees as movements, and reports what is wrong with them: transformers, brackets, and uses of phrases."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

from improv_core.diagnostics import SEVERITIES, Diagnostic, Severity, replace
from improv_core.program import misuse
from improv_core.program.limits import FEW, TOO_LONG, share_a_denominator, too_much
from improv_core.program.numbers import RULES, Rule, above_zero, any_number, plain_value, product
from improv_core.score import dice, movement, ramps, reactions
from improv_core.score.movement import (
    ENDLESS,
    MOST_DEPTH,
    MOST_VOICES,
    SAME,
    Duration,
    Movement,
    all_by,
)
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Call, Name, Node, Number, Parameter
from improv_core.syntax.parser import DEEPEST
from improv_core.text import Span

NOTHING = movement.series(())
MOST_EXPANDED = 10_000
"""The most pairs of a phrase and its arguments that one statement may need."""
MOST_READ = 100_000
"""The most nodes that one statement may read in bodies of phrases."""
MOST_KNOWN = 1_000
"""The most expansions of one phrase that are kept for other statements."""


@dataclass(frozen=True, slots=True, eq=False)
class Phrase:
    """What a use of a phrase with parameters needs. `settled` has read the nodes in the body that mention no parameter:
    they are the same in every use, and `size` counts the others. `known` are expansions that need no arguments but
    numbers and no other phrases.
    """

    parameters: tuple[Parameter, ...]
    body: Node
    scope: Scope
    settled: Reader
    size: int
    known: dict[tuple[Fraction, ...], Expansion] = field(default_factory=dict)

    @property
    def numbers(self) -> Sequence[Parameter]:
        return [each for each in self.parameters if each.is_number]

    @property
    def movements(self) -> Sequence[Parameter]:
        return [each for each in self.parameters if not each.is_number]


class Items(NamedTuple):
    """The terms of the series that a movement is, and the statement in which they are written."""

    movements: tuple[Movement, ...]
    statement: int


@dataclass(frozen=True, slots=True, eq=False)
class Definition:
    """What a name stands for after the statement with this ID.

    A phrase with parameters has no movement and no items until it is used.
    """

    name: str
    statement: int
    movement: Movement
    items: Items
    phrase: Phrase | None = None

    @property
    def head(self) -> str:
        """How it is written: `poly n`, `times n (m)`."""
        parameters = self.phrase.parameters if self.phrase else ()
        return " ".join([self.name, *(each.name if each.is_number else f"({each.name})" for each in parameters)])


Scope = Mapping[str, Definition | None]
"""What each name in a statement stands for; None if nothing above the statement defines it."""


class Argument(NamedTuple):
    """A movement given to a phrase, the statement it is written in, and how deeply it is nested."""

    movement: Movement
    items: Items
    statement: int
    height: int


@dataclass(frozen=True, slots=True, eq=False)
class Given:
    """The arguments of one use of a phrase, by the names of its parameters."""

    phrase: str
    numbers: Mapping[str, Fraction]
    movements: Mapping[str, Argument]


NOBODY = Given("", {}, {})


class Fault(NamedTuple):
    """An error that depends on the arguments of a phrase, and the parameter whose argument causes it, if one does."""

    code: str
    message: str
    parameter: str | None


@dataclass(frozen=True, slots=True, eq=False)
class Expansion:
    """What a phrase means with these arguments. `height` is how deeply it is nested."""

    reader: Reader
    body: Node
    movement: Movement
    height: int


@dataclass(slots=True)
class Reading:
    """What all readers of one statement share.

    `robot` is the place of the robot that plays among the `robots` of the line, for `canon`. `too_much` is
    set to a code and a message once phrases need too much, and then none is expanded any more. `read` counts the nodes
    that were read in bodies of phrases.
    """

    robot: int = 0
    robots: int = 0
    too_much: tuple[str, str] | None = None
    read: int = 0
    expansions: dict[tuple[object, ...], Expansion] = field(default_factory=dict)


@dataclass(slots=True, eq=False)
class Reader:
    """Reads the nodes of one statement, or of a phrase with its arguments.

    `made` holds the movements of all nodes except primitives, by `id`. `found` are the diagnostics in the statement,
    and `faults` those that depend on the arguments of the phrase. `level` is how deeply the node being read is nested,
    through phrases, and `deepest` the deepest level so far. `removable` are the empty brackets, by `id`, that can be
    removed: the statement can be read without them.
    """

    scope: Scope
    statement: int
    reading: Reading
    given: Given = NOBODY
    settled: Reader | None = None
    level: int = 0
    deepest: int = 0
    made: dict[int, Movement] = field(default_factory=dict)
    calls: dict[int, Expansion] = field(default_factory=dict)
    removable: set[int] = field(default_factory=set)
    found: list[Diagnostic] = field(default_factory=list)
    faults: list[Fault] = field(default_factory=list)

    def movement(self, node: Node) -> Movement:
        """The movement of a node. A node with an error counts as an empty movement."""
        if isinstance(node, nodes.Primitive):
            return node.movement
        if self.settled is not None and id(node) in self.settled.made:
            return self.settled.made[id(node)]
        made = self._named(node) if isinstance(node, Name) else self._checked(node)
        self.made[id(node)] = made
        return made

    def movement_made(self, node: Node) -> Movement:
        """The movement of a node that has been read. One that is nested too deeply to be read counts as empty."""
        if isinstance(node, nodes.Primitive):
            return node.movement
        return self.made.get(id(node)) or (self.settled.made.get(id(node)) if self.settled else None) or NOTHING

    def duration(self, node: Node) -> Duration:
        """How many beats a node that has been read lasts."""
        return self.movement_made(node).duration

    def expansion(self, call: Call) -> Expansion | None:
        """What a use of a phrase that has been read means; None if it is wrong."""
        return self.calls.get(id(call)) or (self.settled.calls.get(id(call)) if self.settled else None)

    def items(self, node: Node) -> Items:
        """The terms of the series that a node is, seen through parentheses, names, and phrases. It has been read."""
        node = _inside_parentheses(node)
        if isinstance(node, nodes.Series):
            made = self.movement_made(node)
            if isinstance(made, movement.Series) and len(made.items) == len(node.items):
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

    def number(self, number: Number, what: str) -> Fraction | None:
        """The exact value of a number above zero. Anything else is reported and gives None."""
        return self._number(number, what, above_zero)

    def numbers(self, node: Node) -> Sequence[Fraction | None]:
        """The exact values of the numbers of a node; None for those that are wrong or not known yet."""
        if isinstance(node, nodes.Apply):
            word = node.word.text
            return [self._number(each, f"the number after `{word}`", RULES[word]) for each in node.numbers]
        return [self._number(each, "this number", any_number) for each in nodes.numbers(node)]

    def report(self, diagnostic: Diagnostic, cause: Node | Number) -> None:
        """Report what is wrong. In a phrase, an error is reported at each use, at the argument that causes it."""
        if self.given is NOBODY:
            if diagnostic not in self.found:
                self.found.append(diagnostic)
        elif SEVERITIES[diagnostic.code] is Severity.ERROR:
            parameter = self._culprit(diagnostic.code, cause)
            if parameter or not isinstance(cause, Number):  # a number without parameters is reported where it stands
                message = f"in `{self.given.phrase}`: {diagnostic.message}"
                self._fault(Fault(diagnostic.code, message, parameter))

    def _fault(self, fault: Fault) -> None:
        if fault not in self.faults:
            self.faults.append(fault)

    def _culprit(self, code: str, cause: Node | Number) -> str | None:
        """The parameter in a faulty node or number whose argument most likely causes the error."""
        names = list(dict.fromkeys(nodes.mentions(cause, self.given.movements)))
        if code in ("endless-reverse", "open-length"):
            given = self.given.movements
            causes = (name for name in names if name in given and _has_no_known_end(given[name].movement))
            return next(causes, next(iter(names), None))
        return next(iter(names), None)

    def _number(self, number: Number, what: str, wrong: Rule) -> Fraction | None:
        """The exact value of a number for which `wrong` has no words that say how to write it better."""
        values = self.given.numbers
        value = product(number.tokens, values) if values else plain_value(number.text)
        if value is None:
            return None
        problem = value if isinstance(value, str) else wrong(value)
        if problem:
            self.report(Diagnostic("bad-number", number.span, f"write {what} {problem}"), number)
        return None if problem or isinstance(value, str) else value

    def _checked(self, node: Node) -> Movement:
        if isinstance(node, (nodes.Series, nodes.Parallel)):
            made = self._made(node)
        else:
            self.level += 1
            if self.level > self.deepest:
                self.deepest = self.level
            made = self._too_deep() if self.deepest > DEEPEST else self._made(node)
            self.level -= 1
        if made.bounds.open and made.depth > MOST_DEPTH:
            message = f"what senses decide is nested more than {MOST_DEPTH} levels deep here: use fewer"
            self.report(Diagnostic("too-deep", node.span, message), node)
            return NOTHING
        if problem := too_much(made):
            span = node.numbers[0].span if isinstance(node, nodes.Apply) and node.numbers else node.span
            self.report(Diagnostic("bad-number", span, problem), node)
            return NOTHING
        return made

    def _too_deep(self) -> Movement:
        message = f"with the phrases in it, this is nested more than {DEEPEST} levels deep: use fewer"
        self.reading.too_much = ("too-deep", message)
        return NOTHING

    def _made(self, node: Node) -> Movement:
        if isinstance(node, nodes.Series):
            self.removable.update(id(each) for each in node.items if isinstance(each, nodes.Bracket) and not each.body)
            items = [self.movement(item) for item in node.items]
            return movement.series(items) if len(items) < FEW or self._add_up(node, items) else NOTHING
        if isinstance(node, nodes.Apply):
            return self._applied(node)
        if isinstance(node, nodes.Bracket):
            return self._bracketed(node)
        if isinstance(node, nodes.Parallel):
            return self._together(node, [self.movement(voice) for voice in node.voices])
        if isinstance(node, Call):
            return self._called(node)
        if isinstance(node, nodes.Choice):
            then, otherwise = self._side(node.then), self._side(node.otherwise)
            return reactions.if_else(then, otherwise, _condition(node.condition), node.word.span)
        return NOTHING

    def _side(self, side: Node) -> Movement:
        """One side of an `if`. Only there, empty brackets mean something: to do nothing."""
        is_empty = isinstance(side, nodes.Bracket) and side.body is None
        if is_empty:
            self.made[id(side)] = NOTHING
        return NOTHING if is_empty else self.movement(side)

    def _named(self, name: Name) -> Movement:
        if argument := self.given.movements.get(name.text):
            self.deepest = max(self.deepest, self.level + argument.height)
            return movement.use(argument.movement, name.span, argument.statement)
        definition = self.scope.get(name.text)
        if not definition or definition.phrase:  # a phrase lacks its arguments here
            return NOTHING
        return movement.use(definition.movement, name.span, definition.statement)

    def _called(self, call: Call) -> Movement:
        """A use of a phrase. If its arguments are not as its head says, that is reported elsewhere."""
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
        return movement.use(expansion.movement, call.name.span, definition.statement)

    def _argument(self, node: Node) -> Argument:
        before, self.deepest = self.deepest, self.level
        made = self.movement(node)
        height = self.deepest - self.level
        self.deepest = max(before, self.deepest)
        passed_on = self.given.movements.get(node.text) if isinstance(node, Name) else None
        if passed_on:  # as it is: wherever a parameter is passed on, it is the same argument, and expanded once
            return passed_on
        return Argument(made, self.items(node), self.statement, height)

    def _expanded(
        self,
        definition: Definition,
        phrase: Phrase,
        numbers: Sequence[Fraction],
        arguments: Sequence[Argument],
    ) -> Expansion:
        """What a phrase means with these arguments."""
        reading = self.reading
        key = (definition, *numbers, *(each.movement for each in arguments))
        known = reading.expansions.get(key) or (None if arguments else phrase.known.get(tuple(numbers)))
        if known:
            reading.expansions[key] = known
            return known
        if len(reading.expansions) >= MOST_EXPANDED:
            message = f"phrases within phrases need more than {MOST_EXPANDED:,} parts here: use fewer"
            reading.too_much = ("too-large", message)
        reading.read += phrase.size
        if reading.read > MOST_READ:
            message = f"the phrases used here have more than {MOST_READ:,} words together: use fewer or shorter ones"
            reading.too_much = ("too-large", message)
        named_numbers = {each.name: value for each, value in zip(phrase.numbers, numbers, strict=True)}
        named_movements = {each.name: argument for each, argument in zip(phrase.movements, arguments, strict=True)}
        given = Given(definition.name, named_numbers, named_movements)
        reader = Reader(
            phrase.scope, definition.statement, reading, given, phrase.settled, level=self.level, deepest=self.level
        )
        made = reader.movement(phrase.body)
        expansion = Expansion(reader, phrase.body, made, reader.deepest - self.level)
        reading.expansions[key] = expansion
        if not arguments and not reader.calls and not reading.too_much and len(phrase.known) < MOST_KNOWN:
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
            self._fault(Fault(fault.code, fault.message, self._culprit(fault.code, cause or call)))

    def _add_up(self, node: Node, items: Sequence[Movement]) -> bool:
        """Whether the durations of items can be added exactly. If not, that is reported."""
        if share_a_denominator(items):
            return True
        self.report(Diagnostic("bad-number", node.span, TOO_LONG), node)
        return False

    def _together(self, node: Node, voices: Sequence[Movement]) -> Movement:
        made = movement.parallel(voices)
        if made.width > MOST_VOICES:
            message = f"{made.width:,} voices play at once here, and {MOST_VOICES} is the most: use fewer"
        elif made.depth > MOST_DEPTH:
            message = f"voices within voices are more than {MOST_DEPTH} deep here: use fewer"
        else:
            return made
        self.report(Diagnostic("too-deep", node.span, message), node)
        return NOTHING

    def _bracketed(self, node: nodes.Bracket) -> Movement:
        if node.body is None:
            message = f"`{'[]' if node.squeezes else '()'}` is empty: write a movement in it or remove it"
            fixes = replace("Remove it", node.span, "") if id(node) in self.removable else ()
            self.report(Diagnostic("empty-group", node.span, message, fixes), node)
            return NOTHING
        if not node.squeezes:
            return self.movement(node.body)
        voices = node.body.voices if isinstance(node.body, nodes.Parallel) else (node.body,)
        paced = [movement.pace(self.movement(voice), Fraction(nodes.items(voice))) for voice in voices]
        made = self._together(node, paced)
        is_a_beat = made.open or made.duration in (0, 1)
        if not is_a_beat and all(self.scope.get(each.text, self) for each in nodes.names(node)):
            long = "never ends" if made.duration == ENDLESS else f"takes {made.duration} beats, not one"
            self.report(Diagnostic("bracket-not-a-beat", node.span, f"this bracket {long}"), node)
        return made

    def _applied(self, node: nodes.Apply) -> Movement:
        body = self.movement(node.body)
        word = node.word.text
        if node.condition:
            return _REACTIONS[word](body, _condition(node.condition), node.word.span)
        if body.open and word in (*_ENDING, "chance"):
            self.report(misuse.open_length(node, self.movement_made), node)
            return NOTHING
        if word in _ENDING and isinstance(body.duration, float):
            self.report(misuse.endless(node, self.movement_made), node)
            return NOTHING
        numbers: Sequence[Fraction] = ()
        if node.numbers:
            numbers = [value for value in self.numbers(node) if value is not None]
            if len(numbers) < len(node.numbers):
                return body
        if word == "reflect":
            return movement.gain(body, node.plane.velocity if node.plane else SAME)
        if word == "repeat":
            return movement.repeat(body, *map(int, numbers))
        if word in _WITHOUT_ARGUMENT:
            return _WITHOUT_ARGUMENT[word](body)
        if word in _FROM_ITEMS:
            return self._from_items(node)
        if word == "ramp":
            return self._ramped(node, body, *numbers)
        return self._by(node, body, *numbers) if numbers else body

    def _by(self, node: nodes.Apply, body: Movement, factor: Fraction) -> Movement:
        word = node.word.text
        if word == "fit":
            return movement.fit(body, movement.exact(factor))
        if word == "chance":
            return dice.chance(body, factor, node.word.span)
        if word == "canon":
            return self._in_canon(node, body, factor)
        if word == "seed":
            if not body.dice:
                message = f"nothing in it throws dice, so `seed` changes nothing: remove `{misuse.written(node)}`"
                # Without a word of dice, a `||` around it takes no throw, so later throws fall differently.
                self.report(misuse.without_effect(node, message, safe=False), node)
            return dice.seed(body, factor)
        if factor == 1 and len(node.numbers[0].tokens) == 1:  # 8/8 in a row of eighths is no error
            message = f"`{misuse.written(node)}` changes nothing: remove it or use another number"
            self.report(misuse.without_effect(node, message), node)
        if word == "scale":
            return movement.gain(body, all_by(factor))
        return movement.pace(body, factor if word == "fast" else 1 / factor)

    def _in_canon(self, node: nodes.Apply, body: Movement, beats: Fraction) -> Movement:
        robot, robots = self.reading.robot, self.reading.robots
        if not robots or self.given is not NOBODY:
            return body  # it stands in a definition, and that is reported
        if robots == 1:
            message = f"`canon` needs several robots before `$`: add one or remove `{misuse.written(node)}`"
            self.report(misuse.without_effect(node, message), node)
            return body
        before, after = beats * robot, beats * (robots - 1 - robot)
        return movement.series([_standing(before), body, _standing(after)])

    def _ramped(self, node: nodes.Apply, body: Movement, start: Fraction, end: Fraction) -> Movement:
        if start or end:
            return ramps.ramp(body, start, end)
        message = "write a number above 0 after `ramp`: with two zeros it never moves"
        span = Span(node.numbers[0].span.start, node.numbers[1].span.end)
        self.report(Diagnostic("bad-number", span, message), node)
        return body

    def _from_items(self, node: nodes.Apply) -> Movement:
        """`accumulate`, `choose`, or `shuffle` of the items of a movement."""
        word, found = node.word.text, self.items(node.body)
        items = found.movements
        if found.statement != self.statement:
            span = _inside_parentheses(node.body).span
            items = tuple([movement.use(item, span, found.statement) for item in items])
        if len(items) >= FEW and not self._add_up(node, items):
            return NOTHING
        if len(items) == 1:
            message = f"there is one item to {word} here: write several in brackets or remove `{word}`"
            # If a word of dice goes, it takes no throw, so later throws of the line fall differently.
            self.report(misuse.without_effect(node, message, safe=False), node)
        if word == "choose" and any(item.open for item in items):
            self.report(misuse.open_length(node, self.movement_made), node)
            return NOTHING
        if word == "choose" and len({item.duration for item in items}) > 1:
            self.report(misuse.uneven(node, items_written(node.body), items), node)
            return NOTHING
        return _FROM_ITEMS[word](items)


def takes(phrase: Phrase | None, call: Call) -> bool:
    """Whether a use has as many arguments of each kind as the head of a phrase says."""
    if not phrase:
        return not call.numbers and not call.movements
    return len(call.numbers) == len(phrase.numbers) and len(call.movements) == len(phrase.movements)


def _inside_parentheses(node: Node) -> Node:
    while isinstance(node, nodes.Bracket) and not node.squeezes and node.body:
        node = node.body
    return node


def items_written(node: Node) -> Sequence[Node]:
    """The items of a movement, if they are written where the movement is."""
    inside = _inside_parentheses(node)
    return inside.items if isinstance(inside, nodes.Series) else ()


def _standing(beats: Fraction) -> Movement:
    return movement.stand(movement.exact(beats))


def _condition(condition: nodes.Condition) -> reactions.Condition:
    return reactions.Condition(condition.sense.text, not condition.is_negated)


def _has_no_known_end(made: Movement) -> bool:
    return made.open or made.duration == ENDLESS


_ENDING = frozenset({"reverse", "retrograde", "fit", "ramp", "ease"})
"""Words that need a movement that ends."""
_WITHOUT_ARGUMENT: Mapping[str, Callable[[Movement], Movement]] = {
    "reverse": movement.reverse,
    "retrograde": lambda body: movement.gain(movement.reverse(body), all_by(Fraction(-1))),
    "ease": ramps.ease,
}
_REACTIONS = {"until": reactions.until, "pause": reactions.pause}
_FROM_ITEMS: Mapping[str, Callable[[Sequence[Movement]], Movement]] = {
    "accumulate": movement.accumulate,
    "choose": dice.choose,
    "shuffle": dice.shuffle,
}
