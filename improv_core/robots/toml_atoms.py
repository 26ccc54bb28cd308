"""Atoms of a TOML text: keys, values, and signs.

tree-sitter's grammar finds them, even in half-typed text. If the grammar is not available, as in a browser, plain
Python reads the text instead: valid text then has the same atoms.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from improv_core.text import Span

if TYPE_CHECKING:
    from tree_sitter import Node, Parser


class Atom(NamedTuple):
    """A key, a value, or a sign. `kind` is "key", "value", or the sign itself."""

    kind: str
    span: Span
    text: str


_KINDS = {"bare_key": "key", "quoted_key": "key"} | dict.fromkeys(
    ("string", "integer", "float", "boolean", "offset_date_time", "local_date_time", "local_date", "local_time"),
    "value",
)
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
    parser = _parser()
    return tuple(_parsed(text, parser) if parser else plain_atoms(text))


def plain_atoms(text: str) -> Iterator[Atom]:
    """Yield the atoms of a statement, found without the grammar."""
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


def _parsed(text: str, parser: Parser) -> Iterator[Atom]:
    # Other characters than ASCII appear only in strings and comments, so one `?` for each of them keeps the offsets.
    tree = parser.parse(text.encode("ascii", "replace"))
    waiting: list[Node] = [tree.root_node]
    while waiting:
        node = waiting.pop()
        kind = _KINDS.get(node.type, node.type)
        if node.type in _KINDS or node.type in _SIGNS:
            span = Span(node.start_byte, node.end_byte)
            if span.start < span.end:  # otherwise the parser only expected it there
                yield Atom(kind, span, text[slice(*span)])
        else:
            waiting += reversed(node.children)


@lru_cache(maxsize=1)
def _parser() -> Parser | None:
    try:
        import tree_sitter
        import tree_sitter_toml
    except ImportError:
        return None
    return tree_sitter.Parser(tree_sitter.Language(tree_sitter_toml.language()))
