"""The exact values of numbers, and advice on how to write wrong ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache

from improv_core.score.movement import MOST_BITS, bits
from improv_core.syntax.lexer import Token, lex
from improv_core.syntax.words import above_zero

LONGEST_NUMBER = 30
"""The most characters of one number."""

Values = Mapping[str, Fraction]
"""The arguments of parameters that are numbers, by name."""


def value_of(text: str) -> Fraction | str:
    """Return the exact value of a number above zero, or words that say how to write one."""
    value = plain_value(text) or Fraction(0)
    return value if isinstance(value, str) else above_zero(value) or value


@lru_cache(maxsize=1_000)
def plain_value(text: str) -> Fraction | str | None:
    """Return the exact value of a number without parameters, like `product`."""
    return product(lex(text), {})


def product(tokens: Sequence[Token], values: Values) -> Fraction | str | None:
    """Return the exact value of numbers and parameters with `*` or `/` between them, or words that say how to write
    them.

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
    return (above_zero(value) or value) if value < 0 else value
