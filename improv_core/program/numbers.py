"""The exact values of numbers, and how to write those that are wrong."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from functools import lru_cache

from improv_core.score.movement import MOST_BITS, bits
from improv_core.syntax.lexer import Token, lex

LONGEST_NUMBER = 30
"""The most characters of one number."""

Values = Mapping[str, Fraction]
"""The arguments of parameters that are numbers, by name."""

Rule = Callable[[Fraction], str | None]
"""Says how to write a number better, if it is wrong."""

_ABOVE_ZERO = "as a number above 0"


def value_of(text: str) -> Fraction | str:
    """The exact value of a number above zero, or words that say how to write one."""
    value = plain_value(text)
    return value if isinstance(value, str) or (value is not None and value > 0) else _ABOVE_ZERO


@lru_cache(maxsize=1_000)
def plain_value(text: str) -> Fraction | str | None:
    """The exact value of a number without parameters, as `product` gives it."""
    return product(lex(text), {})


def product(tokens: Sequence[Token], values: Values) -> Fraction | str | None:
    """The exact value of numbers and parameters with `*` or `/` between them, or words that say how to write them.

    None if a number is missing, or a parameter has no value.
    """
    total: Fraction | None = None
    divides = False
    for token in tokens:
        if token.type == "OPERATOR":
            divides = token.text == "/"
            continue
        factor = _factor(token.text) if token.type == "NUMBER" else values.get(token.text)
        if factor is None or isinstance(factor, str):
            return factor
        if total is None:
            total = factor
            continue
        if divides and not factor:
            return "without dividing by 0"
        total = total / factor if divides else total * factor
        if bits(total) > MOST_BITS:
            return "with simpler factors: this fraction is too long to compute exactly"
    return total


@lru_cache(maxsize=1_000)
def _factor(text: str) -> Fraction | str | None:
    if not text:
        return None  # it is missing, and the parser has reported it
    if len(text) > LONGEST_NUMBER:
        return f"with at most {LONGEST_NUMBER} characters"
    value = Fraction(text)
    return _ABOVE_ZERO if text.startswith("-") and value else value


def any_number(value: Fraction) -> str | None:
    return None


def above_zero(value: Fraction) -> str | None:
    return None if value > 0 else _ABOVE_ZERO


def _at_least_zero(value: Fraction) -> str | None:
    return None if value >= 0 else "as a number from 0 up"


def _probability(value: Fraction) -> str | None:
    return None if 0 < value <= 1 else "as a number above 0 and at most 1"


def _whole(value: Fraction) -> str | None:
    return None if value.denominator == 1 else "as a whole number: 0, 1, 2, …"


RULES: Mapping[str, Rule] = {
    **dict.fromkeys(("fast", "slow", "scale", "fit", "seed"), above_zero),
    **dict.fromkeys(("ramp", "canon"), _at_least_zero),
    "repeat": _whole,
    "chance": _probability,
}
"""For the numbers of each word: how to write one better, if it is wrong."""
