"""Completion of measures: units directly behind numbers, and usual measures and `radius` behind primitives."""

from __future__ import annotations

from collections.abc import Iterator

from improv_core.ide.completion_item import Item
from improv_core.ide.cursor import BeforeCursor
from improv_core.syntax.lexer import Token
from improv_core.syntax.vocabulary import RADIUS, UNITS, WORDS

A_RADIUS = Item(RADIUS, "keyword", "Drives along a circle with this radius.", f"{RADIUS} ${{1:1m}}")


def turns(word: Token) -> bool:
    """Return whether a token is a word that turns robots."""
    return word.text in WORDS and bool(WORDS[word.text].velocity.yaw)


def default_unit(word: Token) -> str:
    """Return the usual unit behind a primitive or `radius`; "" behind those that take no measure."""
    if word.type != "RADIUS" and (word.text == "rest" or word.text.startswith("half")):
        return ""
    return "deg" if turns(word) else "m"


def usual_measures(word: Token) -> Iterator[Item]:
    """Yield usual measures behind a primitive or `radius`."""
    values = {"deg": ("90deg", "45deg"), "m": ("1m", "50cm")}.get(default_unit(word), ())
    return (Item(value, "number", "meters" if word.type == "RADIUS" else "in one beat") for value in values)


def units_offered(found: BeforeCursor) -> Iterator[Item]:
    """Yield the units that may stand directly behind the number at the cursor, the likelier ones first: under body
    parts, each direction takes what its joint does."""
    head = found.measures
    if found.sign and head:
        fields = ["meters"] if head.type == "RADIUS" else ["meters", "degrees"]
        fields = fields[::-1] if turns(head) else fields
    elif not found.sign and found.opening and found.opening.kind in ("AT", "ROOM"):
        words = [word.text for word in found.opening.words if word.type != "UNIT"]
        fields = ["degrees"] if words[-1:] == ["facing"] else ["meters"]
    else:
        return
    for field in fields:
        for name, unit in UNITS.items():
            if unit.field == field:
                yield Item(name, "value", unit.about)
