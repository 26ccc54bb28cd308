"""What there is to say about a word of the language: its row in the vocabulary."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from fractions import Fraction
from typing import NamedTuple

from improv_core.score.movement import SAME, Movement, Velocity
from improv_core.score.reactions import Condition
from improv_core.text import Span

Rule = Callable[[Fraction], str | None]
"""Says how to write a number better, if it is wrong."""


def any_number(value: Fraction) -> str | None:
    return None


def above_zero(value: Fraction) -> str | None:
    return None if value > 0 else "as a number above 0"


def at_least_zero(value: Fraction) -> str | None:
    return None if value >= 0 else "as a number from 0 up"


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
    """What a word needs of the movement that it applies to."""

    FIXED = auto()  # a length that no sense decides
    END = auto()  # a fixed length, and an end


class Timing(Enum):
    """When what a word applies to plays."""

    KEPT = auto()  # at the beats at which it is written
    PACED = auto()  # at another rate
    FITTED = auto()  # at a rate that depends on its whole length
    BACKWARD = auto()
    TURNS = auto()  # from its beginning again and again
    ELSEWHERE = auto()  # at other beats than written: if part of it plays, any of it may
    DRAWN = auto()  # its items when dice say so, if at all


@dataclass(frozen=True, slots=True)
class Argument:
    """What stands between a word and its movement: a number, a sense, or one of some `choices`.

    `name` stands for it in signatures, and `example` in usages. Usual numbers are offered, with their unit.
    """

    name: str
    example: str
    rule: Rule = any_number
    usual: Sequence[str] = ("2", "3", "3/2")
    unit: str = "factor"
    choices: Sequence[str] = ()


A_NUMBER = Argument("k", "2")
"""A number of which nothing else is known."""


class Applied(NamedTuple):
    """What a word applies to: a movement, its items if they count, and the values of its arguments.

    `is_plain` tells whether its first number is written as one number, not as a product. `robot` is the place of the
    robot that plays among the `robots` of the line. The word is written from `start` up to `end`.
    """

    body: Movement
    start: int
    end: int
    numbers: Sequence[Fraction] = ()
    is_plain: bool = True
    items: Sequence[Movement] = ()
    plane: Velocity = SAME
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
"""Says what is wrong, if something is."""


@dataclass(frozen=True, slots=True)
class Word:
    """A built-in word. All that reads, checks, explains, or offers words asks their rows, and knows no word.

    `make` makes the movement of a word that applies to one, and `velocity` is that of a primitive, or the gain of a
    reflection across a plane. `rate` is how many times as fast the movement plays, by its number.

    `wrong` says how to write its numbers better if they don't go together, and `needless` why it has no effect;
    `{written}` in that stands for the word and its numbers. If it is `removable`, nothing else changes without it then.
    """

    text: str
    kind: Kind
    about: str
    arguments: tuple[Argument, ...] = ()
    shown: str = ""
    """How it is used, if not as a transformer is."""
    velocity: Velocity = SAME
    make: Callable[[Applied], Movement] | None = None
    needs: Needs | None = None
    timing: Timing = Timing.KEPT
    rate: Callable[[Fraction], Fraction] | None = None
    of_items: bool = False
    """Whether it applies to the items of a movement: it sees through parentheses, names, and phrases."""
    is_even: bool = False
    """Whether these have to be of one length."""
    throws: bool = False
    """Whether it throws dice, or chooses which are thrown."""
    by_robot: bool = False
    """Whether it means something else for each robot of a line."""
    poses: bool = True
    """Whether poses may stand in what it applies to, or in what is reflected across it."""
    keeps_path: bool = False
    """Whether a detour with the same end may be written in it instead of a step."""
    wrong: Says | None = None
    needless: Says | None = None
    removable: bool = True

    @property
    def usage(self) -> str:
        """An example: `repeat 4 movement`."""
        return self.shown or " ".join([self.text, *(each.example for each in self.arguments), *self.operands])

    @property
    def operands(self) -> Sequence[str]:
        """What it applies to."""
        return ("movement", "else", "movement") if self.kind is Kind.IF else ("movement",) if self.make else ()
