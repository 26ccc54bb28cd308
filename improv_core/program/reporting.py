"""Report problems of a statement, or of a phrase with its arguments, and compute the values of its numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import NamedTuple

from improv_core.diagnostics import SEVERITIES, Diagnostic, Severity
from improv_core.program.numbers import product
from improv_core.score.movement import ENDLESS, Movement
from improv_core.syntax import nodes
from improv_core.syntax.nodes import Node, Number
from improv_core.syntax.vocabulary import WORDS
from improv_core.syntax.word import Rule, above_zero, any_number


class Items(NamedTuple):
    """The terms of the series that a movement is, and the statement in which they are written."""

    movements: tuple[Movement, ...]
    statement: int


class Argument(NamedTuple):
    """A movement given to a phrase, the statement it is written in, and the number of its nested levels."""

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


@dataclass(slots=True, eq=False, kw_only=True)
class Reporter:
    """The problems of one statement, or of a phrase that is given arguments.

    `found` are the diagnostics in the statement, and `faults` those that depend on the arguments of the phrase.
    """

    given: Given = NOBODY
    found: list[Diagnostic] = field(default_factory=list)
    faults: list[Fault] = field(default_factory=list)

    def number(self, number: Number, what: str) -> Fraction | None:
        """Return the exact value of a number above zero. Report anything else and return None."""
        return self._number(number, what, above_zero)

    def numbers(self, node: Node) -> Sequence[Fraction | None]:
        """Return the exact values of the numbers of a node; None for those that are wrong or not known yet."""
        if isinstance(node, nodes.Apply):
            what, arguments = f"the number after `{node.word.text}`", WORDS[node.word.text].arguments
            return [self._number(each, what, arguments[place].rule) for place, each in enumerate(node.numbers)]
        if isinstance(node, nodes.MeasuredWord):  # a sign is reported elsewhere
            own = nodes.numbers(node)
            return [None if each.is_signed else self._number(each, "this measure", any_number) for each in own]
        return [self._number(each, "this number", any_number) for each in nodes.numbers(node)]

    def report(self, diagnostic: Diagnostic, cause: Node | Number) -> None:
        """Report a problem. In a phrase, an error is reported at each use, at the argument that causes it."""
        if self.given is NOBODY:
            if diagnostic not in self.found:
                self.found.append(diagnostic)
        elif SEVERITIES[diagnostic.code] is Severity.ERROR:
            parameter = self.culprit(diagnostic.code, cause)
            if parameter or not isinstance(cause, Number):  # a number without parameters is reported at its own place
                message = f"in `{self.given.phrase}`: {diagnostic.message}"
                self.fault(Fault(diagnostic.code, message, parameter))

    def fault(self, fault: Fault) -> None:
        if fault not in self.faults:
            self.faults.append(fault)

    def culprit(self, code: str, cause: Node | Number) -> str | None:
        """Return the parameter in a faulty node or number whose argument most likely causes the error."""
        names = list(dict.fromkeys(nodes.mentions(cause, self.given.movements)))
        if is_cause := _CAUSES.get(code):
            given = self.given.movements
            causes = (name for name in names if name in given and is_cause(given[name].movement))
            return next(causes, next(iter(names), None))
        return next(iter(names), None)

    def _number(self, number: Number, what: str, wrong: Rule) -> Fraction | None:
        """Return the exact value of a number, unless `wrong` has words that say how to write it better."""
        values = self.given.numbers
        value = product(number.tokens, values)
        if value is None:
            return None
        problem = value if isinstance(value, str) else wrong(value)
        if problem:
            self.report(Diagnostic("bad-number", number.span, f"write {what} {problem}"), number)
        return None if problem or isinstance(value, str) else value


def _has_no_known_end(made: Movement) -> bool:
    return made.open or made.duration == ENDLESS


_CAUSES: Mapping[str, Callable[[Movement], bool]] = {
    "endless-reverse": _has_no_known_end,
    "open-length": _has_no_known_end,
    "pose-reversed": lambda made: made.body_words.has_poses,
}
