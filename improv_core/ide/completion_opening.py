"""Completion in the lines of the opening: places, formations, profiles, the floor, and the bar."""

from __future__ import annotations

from collections.abc import Iterator

from improv_core.ide.completion_item import Item
from improv_core.ide.hover_opening import kind
from improv_core.program.analysis import Analysis
from improv_core.syntax.lexer import Token
from improv_core.syntax.nodes import Statement
from improv_core.syntax.opening import FACINGS, SHAPES


def first_words(analysis: Analysis) -> Iterator[Item]:
    """Yield words with which a line of the opening may begin, except those that the program already has."""
    opening = analysis.opening
    if not opening.room:
        yield Item("room", "keyword", "The floor, in meters along x and along y, with walls.", "room ${1:6} ${2:4}")
    if not opening.bar:
        yield Item("bar", "keyword", "Sets the number of beats in a bar.", "bar ${1:4}")


def after_robots() -> Iterator[Item]:
    """Yield the words that may follow robots instead of `$`."""
    yield Item("at", "keyword", "Sets the start places of the robots before it.")
    yield Item("is", "keyword", "Sets the profile of the robots before it.")


def usual_numbers(word: str) -> Iterator[Item]:
    """Return usual numbers after `room` or `bar`."""
    return _numbers("meters", "4", "6", "8") if word == "room" else _numbers("beats", "3", "4")


def offers(analysis: Analysis, line: Statement, tokens: list[Token]) -> Iterator[Item]:
    """Yield the words that may follow these tokens in a line of the opening."""
    sign = line.sign
    assert sign
    rest = [token for token in tokens if token.start >= sign.end]
    if sign.type == "IS" and not rest:
        for name, profile in analysis.config.profiles.items():
            yield Item(name, "value", kind(profile))
    elif sign.type == "AT":
        yield from _places(rest, sign, is_one=len(line.heads) == 1)
    elif sign.type == "ROOM" and len(rest) < 2:
        yield from usual_numbers("room")


def _places(rest: list[Token], sign: Token, *, is_one: bool) -> Iterator[Item]:
    if not rest:
        if is_one:
            yield Item("0 0", "number", "x and y, in meters", "${1:0} ${2:0}")
        for each in SHAPES:
            size = "1.5" if each == "circle" else "1"
            yield Item(each, "value", _ABOUT[each], f"{each} ${{1:{size}}}")
        return
    last, before = rest[-1], rest[-2] if rest[1:] else sign
    shape = rest[0].text if rest[0].text in SHAPES else None
    if last.text == "facing" and last.type == "NAME":
        if shape:
            for facing in FACINGS:
                yield Item(facing, "value", f"they face {facing}ward")
        else:
            yield from _numbers("degrees, counterclockwise from x", "0", "90", "180", "-90")
    elif last.text in (*SHAPES, "around") or (before.text in ("at", "around") and last.type == "NUMBER"):
        yield from _numbers("meters", "0" if last.type == "NUMBER" or last.text == "around" else "1", "2")
    elif last.type == "NUMBER" or last.text in FACINGS:
        said = {token.text for token in rest}
        if "facing" not in said and shape in (None, "circle"):
            what = "degrees, counterclockwise from x" if shape is None else "in or out"
            yield Item("facing", "keyword", what, f"facing ${{1:{'90' if shape is None else 'in'}}}")
        if "around" not in said and shape:
            yield Item("around", "keyword", "the middle, in meters", "around ${1:0} ${2:0}")


_ABOUT = {
    "circle": "on a circle with this radius",
    "line": "side by side, this far apart",
    "grid": "in rows and columns, this far apart",
}


def _numbers(unit: str, *values: str) -> Iterator[Item]:
    return (Item(value, "number", unit) for value in values)
