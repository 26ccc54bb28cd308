"""The JSON of a movement's fields: writes values, reads them again, and checks them. Standard library only."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Any

from improv_core.score.json_types import read
from improv_core.score.measured import Component, Measure
from improv_core.score.movement import MAX_THROWS, Exact, Factors, JsonForm, Velocity, exact
from improv_core.text import Span

_FRACTION = re.compile(r"-?[0-9]{1,2000}(?:/[0-9]{1,2000})?")


def written(value: Exact) -> int | str:
    """Return an exact number for JSON: an int if it is whole, otherwise text."""
    return value.numerator if value.denominator == 1 else str(value)


@lru_cache(maxsize=1_000)
def read_exact(value: int | str) -> Exact:
    """Return the number that `written` wrote. Raises ValueError or TypeError on anything else."""
    if isinstance(value, int):
        return value
    if not _FRACTION.fullmatch(value):  # an exponent would make a number of any length
        raise ValueError("a number is wrong")
    return exact(Fraction(value))


def above_zero(value: int | str) -> Exact:
    """Return an exact number above zero. Raises ValueError or TypeError on anything else."""
    number = read_exact(value)
    if number <= 0:
        raise ValueError("a number is not above zero")
    return number


def _read_as(hint: Any) -> JsonForm:
    """Return the form of a value that JSON has as it is."""
    return JsonForm(lambda value: value, lambda value: read(value, hint))


def _component(value: Component) -> Any:
    """Return a component for JSON: a number, or a list of the coefficients of one that is measured."""
    return [written(exact(Fraction(each))) for each in value] if isinstance(value, Measure) else written(value)


def _read_component(value: Any) -> Component:
    return Measure(*map(read_exact, value)) * 1 if isinstance(value, list) else read_exact(value)


def _count(value: object) -> int:
    if type(value) is not int or not 0 <= value <= MAX_THROWS:
        raise ValueError("a count is wrong")
    return value


def _span(value: Sequence[int] | None) -> Span | None:
    if value is None:
        return None
    start, end = value
    if type(start) is not int or type(end) is not int:
        raise ValueError("a span is wrong")
    return Span(start, end)


NUMBER = JsonForm(written, read_exact)
FRACTION = JsonForm(str, lambda value: Fraction(read_exact(value)))
RATE = JsonForm(str, lambda value: Fraction(above_zero(value)))
BEATS = JsonForm(written, above_zero)
FACTORS = JsonForm(lambda value: list(map(written, value)), lambda value: Factors(*map(read_exact, value)))
VELOCITY = JsonForm(lambda value: list(map(_component, value)), lambda value: Velocity(*map(_read_component, value)))
COUNT = JsonForm(lambda value: value, _count)
TIMES = JsonForm(lambda value: value, lambda value: None if value is None else _count(value))
TEXT, TRUTH, STATEMENT = map(_read_as, (str, bool, int))
SPAN = JsonForm(lambda value: value, _span)
