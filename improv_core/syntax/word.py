"""The row of a word in the vocabulary: everything that Improv knows about the word."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from fractions import Fraction
from typing import NamedTuple

from improv_core.score.movement import SAME, STILL, Factors, Movement, Velocity
from improv_core.score.reactions import Condition
from improv_core.text import Span

Rule = Callable[[Fraction], str | None]
"""Returns how to write a wrong number better; None for a right one."""


def any_number(value: Fraction) -> str | None:
    return None


def above_zero(value: Fraction) -> str | None:
    return None if value.numerator > 0 else "as a number above 0"


def at_least_zero(value: Fraction) -> str | None:
    return None if value.numerator >= 0 else "as a number from 0 up"


def probability(value: Fraction) -> str | None:
    return None if 0 < value <= 1 else "as a number above 0 and at most 1"


def whole(value: Fraction) -> str | None:
    return None if value.denominator == 1 else "as a whole number: 0, 1, 2, …"


class Kind(Enum):
    """The kind of a word. The value is its terminal in the grammar."""

    BEAT = "BEAT"
    PRIMITIVE = "PRIMITIVE"
    PLAIN = "PLAIN"  # a transformer without an argument
    REPEAT = "REPEAT"
    REFLECT = "REFLECT"
    FACTOR = "FACTOR"  # a transformer with a number
    RAMP = "RAMP"
    GUARD = "GUARD"  # a transformer with a condition
    IF = "IF"
    ELSE = "ELSE"
    NOT = "NOT"
    PLANE = "PLANE"


class Needs(Enum):
    """A condition on the movement that a word applies to."""

    FIXED = auto()  # a length that senses don't change
    END = auto()  # a fixed length, and an end


@dataclass(frozen=True, slots=True)
class Argument:
    """An argument between a word and its movement: a number, a sense, or one of some `choices`.

    `name` stands for it in signatures, and `example` in usages. Completion offers the `usual` numbers, with their unit.
    """

    name: str
    example: str
    rule: Rule = any_number
    usual: Sequence[str] = ("2", "3", "3/2")
    unit: str = "factor"
    choices: Sequence[str] = ()


A_NUMBER = Argument("k", "2")
"""A number that has no other restriction."""


class Unit(NamedTuple):
    """A unit: the field of `Measure` that it measures, and its size in meters or degrees."""

    field: str
    size: Fraction
    about: str


class Applied(NamedTuple):
    """The operands of a word: a movement, its items if they count, and the values of its arguments.

    `is_plain` is true if its first number is written as one number, not as a product. `robot` is the place of the robot
    that plays among the `robots` of the line. The word is written from `start` up to `end`.
    """

    body: Movement
    start: int
    end: int
    numbers: Sequence[Fraction] = ()
    is_plain: bool = True
    items: Sequence[Movement] = ()
    plane: Factors = SAME
    condition: Condition | None = None
    otherwise: Movement | None = None
    robot: int = 0
    robots: int = 0

    @property
    def number(self) -> Fraction:
        return self.numbers[0]

    @property
    def span(self) -> Span:
        return Span(self.start, self.end)


Says = Callable[[Applied], str | None]
"""Returns a message about something wrong, if there is any."""


@dataclass(frozen=True, slots=True)
class Word:
    """A built-in word. Code that reads, checks, explains, or offers words uses these rows and names no word itself.

    `make` makes the movement of a word that applies to one, `velocity` is that of a primitive, and `gain` that of a
    reflection across a plane. `rate` maps its number to the rate at which the movement plays.

    `wrong` returns how to write numbers better that don't go together, and `needless` the reason why the word has no
    effect; `{written}` in that stands for the word and its numbers. If it is `removable`, a needless word can be
    removed without other changes.
    """

    text: str
    kind: Kind
    about: str
    arguments: tuple[Argument, ...] = ()
    shown: str = ""
    """An example of its use, if it is not used like a transformer."""
    velocity: Velocity = STILL
    gain: Factors = SAME
    make: Callable[[Applied], Movement] | None = None
    needs: Needs | None = None
    backward: bool = False
    """True if it plays its movement from the end to the beginning."""
    spreads: bool = False
    """True if it plays its movement at a rate that depends on the length of the whole."""
    rate: Callable[[Fraction], Fraction] | None = None
    of_items: bool = False
    """True if it applies to the items of a movement: it sees through parentheses, names, and phrases."""
    is_even: bool = False
    """True if these items must have the same length."""
    throws: bool = False
    """True if it throws dice, or chooses which are thrown."""
    by_robot: bool = False
    """True if it means something else for each robot of a line."""
    poses: bool = True
    """True if poses may stand in its movement, or in the movement that is reflected across it: then a detour with the
    same end may also replace a step, except in a reflection."""
    wrong: Says | None = None
    needless: Says | None = None
    removable: bool = True

    @property
    def usage(self) -> str:
        """Return an example: `repeat 4 movement`."""
        return self.shown or " ".join([self.text, *(each.example for each in self.arguments), *self.operands])

    @property
    def operands(self) -> Sequence[str]:
        """The words after its arguments in its usage."""
        return ("movement", "else", "movement") if self.kind is Kind.IF else ("movement",) if self.make else ()
