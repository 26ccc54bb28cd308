"""The exact values of numbers, advice on how to write wrong ones, and the limits of the movements that they make."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache

from improv_core.score.bounds import is_too_fast
from improv_core.score.movement import ENDLESS, LARGEST, MAX_BITS, MAX_THROWS, Movement, bits
from improv_core.syntax.lexer import Token, lex
from improv_core.syntax.word import above_zero

LONGEST_NUMBER = 30
"""The most characters of one number."""

Values = Mapping[str, Fraction]
"""The arguments of parameters that are numbers, by name."""


def value_of(text: str) -> Fraction | str:
    """Return the exact value of a number above zero, or words that say how to write one."""
    value = product(lex(text), {}) or Fraction(0)
    return value if isinstance(value, str) else above_zero(value) or value


def product(tokens: Sequence[Token], values: Values) -> Fraction | str | None:
    """Return the exact value of numbers and parameters with `*` or `/` between them, or words that say how to write
    them. Units don't count.

    None if a number is missing, or a parameter has no value.
    """
    factors = tuple([token[:2] for token in tokens])
    return _multiplied(factors, values) if values else _constant(factors)


@lru_cache(maxsize=1_000)
def _constant(factors: tuple[tuple[str, str], ...]) -> Fraction | str | None:
    return _multiplied(factors, {})


def _multiplied(factors: Sequence[tuple[str, str]], values: Values) -> Fraction | str | None:
    total: Fraction | None = None
    divides = False
    for kind, text in factors:
        if kind == "OPERATOR":
            divides = text == "/"
        if kind in ("OPERATOR", "UNIT"):
            continue
        factor = _factor(text) if kind == "NUMBER" else values.get(text)
        if factor is None or isinstance(factor, str):
            return factor
        if total is None:
            total = factor
            continue
        if divides and not factor:
            return "without dividing by 0"
        total = total / factor if divides else total * factor
        if bits(total) > MAX_BITS:
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


FEW = 50
"""The most fractions that are added without checking their common denominator."""
_FEW_BITS = 150
"""A movement whose numbers have so few bits is neither too long nor too fast: its factors are below 2^300 together."""
TOO_LONG = "these numbers make a fraction too long to compute exactly: use simpler ones"


def too_much(made: Movement) -> str | None:
    """Return the message about numbers too long to stay exact or too large for a float; None if there are none.

    All code that converts a movement's numbers to floats relies on this check.
    """
    duration, bounds = made.duration, made.bounds
    length = bounds.bits if isinstance(duration, float) else bounds.bits + bits(duration)
    if length <= _FEW_BITS and not bounds.throws:
        return None
    if LARGEST < duration < ENDLESS or is_too_fast(bounds.peak) or is_too_fast(bounds.body.peak):
        return "these numbers make the movement too long or too fast to play: use smaller ones"
    if bounds.throws > MAX_THROWS:
        return "these numbers make too many throws of the dice: use smaller ones"
    return TOO_LONG if length > MAX_BITS else None


def share_a_denominator(items: Sequence[Movement]) -> bool:
    """Return whether durations can be added exactly: a sum of thousands of unrelated fractions keeps getting longer."""
    common = 1
    for item in items:
        if isinstance(item.duration, Fraction):
            common = math.lcm(common, item.duration.denominator)
            if common.bit_length() > MAX_BITS:
                return False
    return True
