"""Atoms of a TOML text, even a half-typed one: keys, values, and signs."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

from improv_core.text import Span


class Atom(NamedTuple):
    """A key, a value, or a sign. `kind` is "key", "value", or the sign itself."""

    kind: str
    span: Span
    text: str


_SIGNS = frozenset(["[", "]", "[[", "]]", "{", "}", "=", ",", "."])
_NOTHING = r"(?P<nothing> [^\S\n]+ | \#[^\r\n]* )"
_STRING = r"""(?P<string> \"{3} (?:\\.|[^\\])*? \"{3,5} | '{3} .*? '{3,5} | "(?:\\[^\n]|[^"\\\n])*" | '[^'\n]*' )"""
_IN_KEYS = re.compile(rf"{_NOTHING} | {_STRING} | (?P<word> [\w-]+ ) | \[\[? | \]\]? | .", re.VERBOSE | re.DOTALL)
_IN_VALUES = re.compile(
    rf"{_NOTHING} | {_STRING} | (?P<word> \d{{4}}-\d\d-\d\d[ ]\d\d:[\w:.+-]+ | [\w+.:-]+ ) | .",
    re.VERBOSE | re.DOTALL,
)


@lru_cache(maxsize=4096)
def atoms(text: str) -> Sequence[Atom]:
    """Return the atoms of a statement. Cached by text: after a key is typed, only the statement around it is new."""
    return tuple(_atoms(text))


def _atoms(text: str) -> Iterator[Atom]:
    open_brackets: list[str] = []
    in_value, at, end = False, 0, len(text)
    while at < end:
        found = (_IN_VALUES if in_value else _IN_KEYS).match(text, at)
        assert found
        at, sign, span = found.end(), found[0], Span(*found.span())
        if found["string"] or found["word"]:
            yield Atom("value" if in_value else "key", span, sign)
        elif sign == "\n":
            in_value = in_value and bool(open_brackets)
        elif sign in _SIGNS:
            yield Atom(sign, span, sign)
            if in_value and sign in "[{":
                open_brackets.append(sign)
            elif sign in "]}" and open_brackets:
                open_brackets.pop()
            if sign in ("=", "}"):
                in_value = True
            elif sign == "{":
                in_value = False
            elif sign == ",":
                in_value = open_brackets[-1:] != ["{"]
