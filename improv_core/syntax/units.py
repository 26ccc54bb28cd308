"""Units as people write them, and the measures that they mean."""

from __future__ import annotations

from fractions import Fraction

from improv_core.diagnostics import Edit
from improv_core.syntax.characters import DEGREES, in_words
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Number
from improv_core.syntax.vocabulary import UNITS
from improv_core.text import Span

_MEANT = {
    **dict.fromkeys(("meter", "meters", "metre", "metres"), ("m", Fraction(1))),
    **dict.fromkeys(("centimeter", "centimeters", "centimetre", "centimetres"), ("cm", Fraction(1))),
    **dict.fromkeys(("millimeter", "millimeters", "millimetre", "millimetres"), ("mm", Fraction(1))),
    **dict.fromkeys(("degree", "degrees", "degs"), ("deg", Fraction(1))),
    **dict.fromkeys(DEGREES, ("°", Fraction(1))),
    "dm": ("m", Fraction(1, 10)),
    "km": ("m", Fraction(1000)),
    **dict.fromkeys(("in", "inch", "inches"), ("m", Fraction(254, 10_000))),
    **dict.fromkeys(("ft", "foot", "feet"), ("m", Fraction(3048, 10_000))),
    **dict.fromkeys(("yd", "yard", "yards"), ("m", Fraction(9144, 10_000))),
}
"""Units that people write, in lowercase, each with ours and its size in that."""


def unit_meant(text: str) -> tuple[str, Fraction] | None:
    """Return the unit that people mean by a word, and the word's size in it; None if it means none."""
    plain = text.lower()
    return (plain, Fraction(1)) if plain in UNITS else _MEANT.get(plain)


def misplaced_unit(number: Number, value: Fraction | None, unit: Token, before: str = "") -> tuple[str, str, Edit]:
    """Return the message about a unit apart from its number, or about one that isn't ours, the title of its fix, and
    the edit. The number has a `value`, unless it has parameters, and follows the word `before`."""
    meant = unit_meant(unit.text)
    assert meant
    ours, size = meant
    is_last_a_number = number.tokens[-1].type == "NUMBER"
    gap, whole = Span(number.span.end, unit.start), Span(number.span.end, unit.end)
    if unit.text in UNITS and is_last_a_number:
        written, edit = f"{number.text}{ours}", Edit(gap, "")
    elif size == 1 and is_last_a_number:
        written, edit = f"{number.text}{ours}", Edit(whole, ours)
    elif value is not None:
        written = f"{float(value * size):.10g}{ours}"
        edit = Edit(Span(number.span.start, unit.end), written)
    else:
        added = f"*{float(size):.10g}{ours}"
        written, edit = f"{number.text}{added}", Edit(whole, added)
    shown = f"{before} {written}".lstrip()
    message = f"write the unit directly behind the number: `{shown}`"
    if unit.text in DEGREES:
        message = f"write `{written}`: this is {in_words(unit.text)}, and no degree sign"
    elif unit.text not in UNITS:
        message = f"`{unit.text}` is not a unit here: write `{shown}`"
    return message, f"Change to {shown}", edit
