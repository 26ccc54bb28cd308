"""A TOML text and the positions of its keys and values, which the standard library's parser does not report."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import tomllib

from improv_core.diagnostics import Diagnostic
from improv_core.text import LineIndex, Span

Keys = tuple[str | int, ...]
"""The keys that lead to a value. For an item of an array, the last one is its index."""


@dataclass(frozen=True, slots=True)
class Entry:
    """The spans of a key and its value. A table that is only named in headers has its first name as both."""

    key: Span
    value: Span


@dataclass(frozen=True, slots=True)
class TomlText:
    """The data of a text and its positions. If it is not valid TOML, there are only `diagnostics`.

    A table may be named many times, in headers and in dotted keys. `named` has all those spans.
    """

    data: Mapping[str, Any] = field(default_factory=dict)
    entries: Mapping[Keys, Entry] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()
    named: Mapping[Keys, Sequence[Span]] = field(default_factory=dict)


def read_toml(text: str) -> TomlText:
    """Read a text. Never raises; invalid TOML gives a `syntax` diagnostic where it is."""
    text = re.sub("^\ufeff", " ", text)  # a byte order mark; the space keeps the offsets
    try:
        data = tomllib.loads(text)
        scanner = _Scanner(text)
        scanner.document()
    except (ValueError, RecursionError) as error:
        return TomlText(diagnostics=(_unreadable(text, str(error)),))
    return TomlText(data, scanner.found, named=scanner.named)


_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_STRING = re.compile(r'"""(?:\\.|[^\\])*?"{3,5}|' r"'''.*?'{3,5}|" r'"(?:\\.|[^"\\])*"|' r"'[^']*'", re.DOTALL)
_BARE_KEY = re.compile(r"[\w-]+")
_BARE_VALUE = re.compile(r"[^,\]}#\r\n]*[^,\]}#\s]")  # there may be a space between a date and its time


@dataclass(slots=True)
class _Scanner:
    """Finds all entries of a text, from left to right. The text is valid, so it need not check for errors."""

    text: str
    at: int = 0
    found: dict[Keys, Entry] = field(default_factory=dict)
    named: dict[Keys, list[Span]] = field(default_factory=dict)
    last: dict[Keys, int] = field(default_factory=dict)  # for each array of tables, the index of its latest table

    def document(self) -> None:
        table: Keys = ()
        self.skip(_BLANK)
        while self.at < len(self.text):
            if self.text[self.at] == "[":
                table = self.header()
            else:
                self.pair(table)
            self.skip(_BLANK)

    def header(self) -> Keys:
        """`[a.b]` or `[[a.b]]`."""
        brackets = 2 if self.text.startswith("[[", self.at) else 1
        self.at += brackets
        table: Keys = ()
        keys = self.keys()
        for place, (name, span) in enumerate(keys, 1):
            table = (*table, name)
            self.name(table, span)
            if brackets == 2 and place == len(keys):
                self.last[table] = self.last.get(table, -1) + 1
            if table in self.last:
                table = (*table, self.last[table])
                self.found.setdefault(table, Entry(span, span))
        self.at += brackets
        return table

    def pair(self, table: Keys) -> None:
        """`a.b = value`."""
        for name, span in self.keys():
            table = (*table, name)
            self.name(table, span)
        self.at += len("=")
        self.skip(_BLANK)
        self.found[table] = Entry(self.found[table].key, self.value(table))

    def name(self, keys: Keys, span: Span) -> None:
        self.found.setdefault(keys, Entry(span, span))
        self.named.setdefault(keys, []).append(span)

    def keys(self) -> list[tuple[str, Span]]:
        """`a . "b"`, and the spaces around it."""
        found = []
        while True:
            self.skip(_BLANK)
            quoted = self.text[self.at] in "\"'"
            span = self.skip(_STRING if quoted else _BARE_KEY)
            name = self.text[slice(*span)]
            found.append((tomllib.loads(f"name = {name}")["name"] if quoted else name, span))
            self.skip(_BLANK)
            if self.text[self.at] != ".":
                return found
            self.at += len(".")

    def value(self, keys: Keys) -> Span:
        first = self.text[self.at]
        if first not in "[{":
            return self.skip(_STRING if first in "\"'" else _BARE_VALUE)
        start, place = self.at, 0
        self.at += len(first)
        self.skip(_BLANK)
        while self.text[self.at] not in "]}":
            if first == "{":
                self.pair(keys)
            else:
                item = (*keys, place)
                span = self.value(item)
                self.found[item] = Entry(span, span)
                place += 1
            self.skip(_BLANK)
            if self.text[self.at] == ",":
                self.at += len(",")
                self.skip(_BLANK)
        self.at += len("]")
        return Span(start, self.at)

    def skip(self, pattern: re.Pattern[str]) -> Span:
        found = pattern.match(self.text, self.at)
        assert found, "the text is valid"
        self.at = found.end()
        return Span(*found.span())


# How to fix what tomllib reports, by the start of its message.
_ADVICE = {
    "Invalid value": 'write a value: a number, "text", [a list] or { a table }',
    "Invalid statement": "write `key = value` or `[section]`",
    "Invalid initial character": "write a key here, or remove the comma before it",
    "Expected '='": "write `=` and a value after the key",
    "Expected newline": "remove this or start a new line with it",
    "Expected ']": "close the section name with `]`",
    "Illegal character '\\n'": "close the string with the same quote it starts with",
    "Unterminated string": "close the string with the same quotes it starts with",
    "Unclosed array": "close the list with `]`",
    "Unclosed inline table": "close the table with `}`, on the line where it starts",
    "Cannot overwrite": "this key already has a value: remove one of them",
    "Duplicate inline table key": "this key already has a value: remove one of them",
    "Cannot declare": "this section already exists above: merge the two",
    "Unescaped": r"write `\\` for one backslash",
}
_MESSAGE = re.compile(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", re.DOTALL)
_WORD = re.compile(r"[^\s,\]}]+|\S?")
# tomllib notices these after the text in question, which starts earlier on the same line.
_BEFORE = {
    "Cannot": re.compile(r"\S.*$"),
    "Duplicate": re.compile(r"[^\s,{][^,{]*$"),
    "Unescaped": re.compile(r"\\.?$"),
}


def _unreadable(text: str, error: str) -> Diagnostic:
    lines = LineIndex(text)
    found = _MESSAGE.fullmatch(error)
    if not found:  # not from tomllib itself but from one of Python's limits
        message = "this file can't be read: nest brackets less deeply and use shorter numbers"
        return Diagnostic("syntax", Span(lines.start(0), lines.end(0)), message)
    what, line, column = found.groups()
    advice = next((advice for start, advice in _ADVICE.items() if what.startswith(start)), None)
    # Lines of TOML end with \n or \r\n, never with \r alone. At the end of the text, mark the last word.
    starts = [0, *(end.end() for end in re.finditer("\n", text))]
    at = starts[int(line) - 1] + int(column) - 1 if line else len(text.rstrip())
    word = _WORD.match(text, at)
    span = Span(*word.span()) if word else Span(at, at)
    before = _BEFORE.get(what.split()[0])
    begin = before and before.search(text, lines.start(lines.position(at).line), at)
    if begin:
        span = Span(begin.start(), at)
    return Diagnostic("syntax", span, advice or f"this is not valid TOML: {what[:1].lower()}{what[1:]}")
