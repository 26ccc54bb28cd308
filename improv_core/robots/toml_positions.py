"""Positions of the keys and values in a TOML text, even a half-typed one, and its atoms. Never raises.

One statement is read at a time, so an unfinished one hides nothing below it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import NamedTuple

import tomllib

from improv_core.text import Span

Keys = tuple[str | int, ...]
"""Keys that lead to a value. For an item of an array, the last one is its index."""


@dataclass(frozen=True, slots=True)
class KeyAndValue:
    """The spans of a key and its value. A table that is only named in headers has its first name as both."""

    key: Span
    value: Span


@dataclass(slots=True)
class Positions:
    """The entries of a text, and what may come next at its end.

    A table may be named many times, in headers and in dotted keys. `named` has all those spans. At the end of the text,
    `keys` lead to the entry that the person is typing: with `expects` "header" or "key", to the table in which a name
    comes next, and with "value", to the value itself. With "name" or "after", only a sign can come next, after a name
    or a value.
    """

    entries: dict[Keys, KeyAndValue] = field(default_factory=dict)
    named: dict[Keys, list[Span]] = field(default_factory=dict)
    headers: list[tuple[Span, Keys]] = field(default_factory=list)
    keys: Keys = ()
    expects: str = "key"

    def nearest(self, keys: Keys) -> KeyAndValue:
        """Return the entry of a key, or of the table around it if fewer entries were found than `tomllib` reads."""
        while keys and keys not in self.entries:
            keys = keys[:-1]
        return self.entries.get(keys, KeyAndValue(Span(0, 0), Span(0, 0)))


def find_positions(text: str) -> Positions:
    walk = _Walk()
    for start, statement in statements(text):
        walk.statement(start, statement)
    return walk.found


def statements(text: str) -> Iterator[tuple[int, str]]:
    """Yield the statements of a text, and their offsets. No line of a multi-line string starts one."""
    inside = iter(multi_line_strings(text))
    string = next(inside, None)
    starts = [0]
    for found in _START.finditer(text):
        while string and string.end <= found.start():
            string = next(inside, None)
        if not string or found.start() <= string.start:
            starts.append(found.start())
    for start, end in zip(starts, [*starts[1:], len(text)], strict=True):
        yield start, text[start:end]


def multi_line_strings(text: str) -> list[Span]:
    """Return the multi-line strings that end, in the order of the text."""
    return [Span(*found.span()) for found in _LITERAL.finditer(text) if found["lines"]]


def comments(text: str) -> list[Span]:
    """Return the comments, from `#` to the end of the line, in the order of the text."""
    return [Span(*found.span()) for found in _LITERAL.finditer(text) if found["comment"]]


def beginning(text: str, offset: int) -> tuple[Positions, str] | None:
    """Return the part of a section before a cursor, and the beginning of the word there; None in a comment."""
    line = text[:offset].rpartition("\n")[2]
    finished = _FINISHED.match(line)
    begun = line[finished.end() :] if finished else ""
    if begun.startswith("#"):
        return None
    begun = begun or line[len(line.rstrip(_WORD)) :]
    before = text[: offset - len(begun)]
    headers = list(_HEADER.finditer(before))
    # Lines above a section don't matter to it, unless they have arrays of tables, which are counted.
    counted = any(header[0].endswith("[[") for header in headers)
    return find_positions(before if counted or not headers else before[headers[-1].start() :]), begun


_WORD = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-"
_FINISHED = re.compile(r""" (?: "(?:\\.|[^"\\])*" | '[^']*' | [^"'#] )* """, re.VERBOSE)
# Only these lines can't continue an array: a header that starts with a word, `key =`, and a word alone.
_START = re.compile(
    r"""^[ \t]*(?: \[\[?[ \t]*(?!(?:true|false|inf|nan)\b)[A-Za-z_]
      | (?:[\w-]+|"[^"\n]*"|'[^'\n]*') (?:[ \t]*\.[ \t]*(?:[\w-]+|"[^"\n]*"|'[^'\n]*'))* [ \t]* =
      | (?!(?:true|false|inf|nan)\b)[A-Za-z_][\w.-]*[ \t]*(?:\#.*)?$ )""",
    re.VERBOSE | re.MULTILINE,
)
_HEADER = re.compile(r"^[ \t]*\[\[?(?=[ \t]*(?!(?:true|false|inf|nan)\b)[A-Za-z_])", re.MULTILINE)
# A string that doesn't end on its line ends with it, so a quote too many hides nothing below.
_LITERAL = re.compile(
    r"""(?P<lines> \"{3} (?:\\.|[^\\])*? \"{3,5} | '{3} .*? '{3,5} )
      | "(?:\\[^\n]|[^"\\\n])*"? | '[^'\n]*'? | (?P<comment>\#[^\r\n]*)""",
    re.VERBOSE | re.DOTALL,
)


_DEEPEST = 100
"""The most nested brackets, and the longest names of keys, to follow. The time grows with the square."""


@dataclass(slots=True)
class _Walk:
    """Follows the atoms of a text from left to right, valid or not."""

    found: Positions = field(default_factory=Positions)
    table: Keys = ()
    last: dict[Keys, int] = field(default_factory=dict)  # for each array of tables, the index of its latest table
    open: list[tuple[str, Keys, Span]] = field(default_factory=list)  # brackets, and the keys that lead to them

    def statement(self, start: int, text: str) -> None:
        self.open.clear()
        self._go("key", self.table)
        for atom in atoms(text):
            span = Span(start + atom.span.start, start + atom.span.end)
            if self.found.expects == "header":
                self._header(atom, span)
            elif self.found.expects in ("key", "name"):
                self._key(atom, span)
            else:
                self._value(atom, span)
            if len(self.open) > _DEEPEST or len(self.found.keys) > _DEEPEST:
                break

    def _go(self, expects: str, keys: Keys) -> None:
        self.found.expects, self.found.keys = expects, keys

    def _header(self, atom: Atom, span: Span) -> None:
        if atom.kind == "key":
            self._name((*self.found.keys, _name(atom.text)), span)
            self.table = self.found.keys
            self.found.headers[-1] = (self.found.headers[-1][0], self.table)
        elif atom.kind == "]]" and self.table:
            self.last[self.table] = self.last.get(self.table, -1) + 1
            self._item(self.found.named[self.table][-1])
        elif atom.kind == "." and self.table in self.last:
            self._item(self.found.named[self.table][-1])
        if atom.kind in ("]", "]]"):
            if atom.kind == "]" and self.table in self.last:
                self._item(self.found.named[self.table][-1])
            self._go("key", self.table)

    def _item(self, span: Span) -> None:
        """Enter the latest table of an array of tables."""
        self.table = (*self.table, self.last[self.table])
        self.found.headers[-1] = (self.found.headers[-1][0], self.table)
        self.found.entries.setdefault(self.table, KeyAndValue(span, span))
        self._go("header", self.table)

    def _key(self, atom: Atom, span: Span) -> None:
        inside = self.open[-1] if self.open else None
        if atom.kind == "key":
            self._name((*self.found.keys, _name(atom.text)), span)
            self.found.expects = "name"
        elif atom.kind == ".":
            self.found.expects = "key"
        elif atom.kind == "=" and self.found.keys != (inside[1] if inside else self.table):
            self._go("value", self.found.keys)
        elif atom.kind == "," and inside:
            self._go("key", inside[1])
        elif atom.kind == "}" and inside:
            self._close(span)
        elif atom.kind in ("[", "[[") and not inside:
            self.table = ()
            self.found.headers.append((span, ()))
            self._go("header", ())

    def _value(self, atom: Atom, span: Span) -> None:
        keys = self.found.keys
        if atom.kind in ("[", "[[", "{"):
            for start in range(*span):  # `[[` opens two arrays
                self.open.append((atom.kind[0], self.found.keys, Span(start, start + 1)))
                self._go(*(("key", self.found.keys) if atom.kind == "{" else ("value", (*self.found.keys, 0))))
        elif atom.kind in ("]", "]]"):
            for start in range(*span):
                self._close(Span(start, start + 1))
        elif atom.kind == "," and self.open:
            bracket, outer, _ = self.open[-1]
            if bracket == "{":
                self._go("key", outer)
            else:
                items = int(keys[-1]) + 1 if keys[:-1] == outer else 1
                self._go("value", (*outer, items))
        elif atom.kind == "}":
            self._close(span)
        elif atom.kind in ("value", "key"):
            self._end_value(span)

    def _close(self, span: Span) -> None:
        if self.open:
            _, keys, start = self.open.pop()
            self.found.keys = keys
            self._end_value(Span(start.start, span.end))

    def _end_value(self, span: Span) -> None:
        """End the value, and with it the statement unless it is inside brackets."""
        keys = self.found.keys
        key = self.found.named[keys][-1] if keys in self.found.named else span
        self.found.entries[keys] = KeyAndValue(key, span)
        if not self.open:
            self._go("key", self.table)
        elif self.open[-1][0] == "{":
            self._go("after", keys)
        else:
            self._go("value", keys)

    def _name(self, keys: Keys, span: Span) -> None:
        self.found.entries.setdefault(keys, KeyAndValue(span, span))
        self.found.named.setdefault(keys, []).append(span)
        self.found.keys = keys


def _name(written: str) -> str:
    if written[0] not in "\"'":
        return written
    try:
        return str(tomllib.loads(f"name = {written}")["name"])
    except tomllib.TOMLDecodeError:
        return written[1:-1]


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
    rf"{_NOTHING} | {_STRING} | (?P<word> \d{{4}}-\d\d-\d\d[ ]\d\d:[\w:.+-]+ | [\w+.:-]+ ) | .", re.VERBOSE | re.DOTALL
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
