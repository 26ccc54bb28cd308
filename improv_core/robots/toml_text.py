"""A TOML text: its data, or why it is not valid, and the positions of its keys and values.

A text that is not valid is read one statement at a time, so that a wrong statement hides no other. Such a text is only
checked; it never plays.
"""

from __future__ import annotations

import dataclasses
import re
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import tomllib

from improv_core.diagnostics import Diagnostic, replace
from improv_core.robots.toml_positions import Keys, Positions, comments, find_positions, statements
from improv_core.slices import checkpoint
from improv_core.text import LineIndex, Span


@dataclass(frozen=True)
class TomlText:
    """The data of a text, and its positions.

    If the text is not valid TOML, there is no data, but there are the positions that can be found. `readable` is the
    data of its valid statements, in which other errors can be found, and `broken` has the tables that may have more
    data.
    """

    text: str
    data: Mapping[str, Any] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()
    readable: Mapping[str, Any] = field(default_factory=dict)
    broken: frozenset[Keys] = frozenset()

    def is_whole(self, keys: Keys) -> bool:
        """True if all of a table could be read. If not, a missing key proves nothing."""
        return not any(keys[: len(each)] == each[: len(keys)] for each in self.broken)

    @cached_property
    def positions(self) -> Positions:
        """Positions, found when they are first needed: a program whose file has no errors needs none."""
        return find_positions(self.text)


@lru_cache(maxsize=4)
def read_toml(text: str) -> TomlText:
    """Read a text. Never raises; invalid TOML gives a `syntax` diagnostic at its position."""
    text = re.sub("^\ufeff", " ", text)  # a byte order mark; the space keeps the offsets
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        found = read_statements(text)
        return found if found.diagnostics else dataclasses.replace(found, diagnostics=(unreadable(text, str(error)),))
    return TomlText(text, data, readable=data)


def read_statements(text: str) -> TomlText:
    """Read the valid statements of a text, and report the others. Never raises.

    Statements below an invalid header are left out, since it isn't known to which table they belong. If a key has two
    values, the first one counts.
    """
    readable: dict[str, Any] = {}
    diagnostics: list[Diagnostic] = []
    broken: set[Keys] = set()
    headers = {span.start: keys for span, keys in find_positions(text).headers}
    declared: set[Keys] = set()
    table: Keys | None = ()  # the table of the statement; None below an invalid header
    for start, statement in _each(text, sorted(headers)):
        checkpoint()
        header = headers.get(start)
        try:
            data = tomllib.loads(statement)
        except (ValueError, RecursionError) as error:
            diagnostics.append(unreadable(statement, str(error), start))
            if header is not None:
                broken |= {header, header[:-1]}
                table = None
            elif table is not None:
                broken.add(table)
            continue
        if header is not None:
            table, data = header, _below(data, header)
            if header in declared:
                diagnostics.append(Diagnostic("syntax", _first_line(start, statement), DUPLICATE_SECTION))
            declared.add(header)
        if table is not None and not _merge(_entered(readable, table), data):
            diagnostics.append(Diagnostic("syntax", _first_line(start, statement), DUPLICATE_KEY))
    return TomlText(text, {}, tuple(diagnostics), readable, frozenset(broken))


def _each(text: str, headers: list[int]) -> Iterator[tuple[int, str]]:
    """Yield the statements of a text, and their offsets. Every header starts one."""
    for start, statement in statements(text):
        end = start + len(statement)
        inside = headers[bisect_right(headers, start) : bisect_left(headers, end)]
        for begin, stop in zip([start, *inside], [*inside, end], strict=True):
            if begin < stop:
                yield begin, text[begin:stop]


def _entered(data: Any, keys: Keys) -> dict[str, Any]:
    """Return the table that keys lead to, and make it if necessary. If it has another value there, return a table that
    belongs to nothing."""
    for key, following in zip(keys, (*keys[1:], ""), strict=False):
        if isinstance(key, str) and isinstance(data, dict):
            data = data.setdefault(key, {} if isinstance(following, str) else [])
        elif isinstance(key, int) and isinstance(data, list) and key <= len(data):
            if key == len(data):
                data.append({})
            data = data[key]
        else:
            return {}
    return data if isinstance(data, dict) else {}


def _below(data: Any, keys: Keys) -> dict[str, Any]:
    """Return the data below a header that was read alone. An array of tables has one table there."""
    for key in keys:
        if isinstance(data, dict):
            data = data.get(str(key), {})
        elif data:
            data = data[0]
    return data if isinstance(data, dict) else {}


def _merge(data: dict[str, Any], more: Mapping[str, Any]) -> bool:
    """Add entries to a table; False if one is there already and was left as it is."""
    fits = True
    for name, value in more.items():
        old = data.setdefault(name, value)
        if isinstance(old, dict) and isinstance(value, dict):
            fits &= old is value or _merge(old, value)
        else:
            fits &= old is value
    return fits


def _first_line(start: int, statement: str) -> Span:
    """Return the span of a statement's first line, without the space and the comment around it."""
    comment = next((span.start for span in comments(statement)), len(statement))
    line = statement.lstrip().partition("\n")[0]
    begin = len(statement) - len(statement.lstrip())
    return Span(begin, begin + len(line[: max(comment - begin, 0)].rstrip())).shifted(start)


DUPLICATE_KEY = "this key already has a value: remove one of them"
DUPLICATE_SECTION = "this section already exists above: merge the two"
# Fixes for the errors that tomllib reports, by the start of its message.
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
    "Cannot overwrite": DUPLICATE_KEY,
    "Duplicate inline table key": DUPLICATE_KEY,
    "Cannot declare": DUPLICATE_SECTION,
    "Unescaped": r"write `\\` for one backslash",
}
_MESSAGE = re.compile(r"(.*) \(at (?:line (\d+), column (\d+)|end of document)\)", re.DOTALL)
_UNQUOTED = re.compile(r"[A-Za-z_/][\w/-]*")
_WORD = re.compile(r"[^\s,\]}]+|\S?")
# tomllib reports these after the wrong text, which starts earlier on the same line.
_BEFORE = {
    "Cannot": re.compile(r"\S.*$"),
    "Duplicate": re.compile(r"[^\s,{][^,{]*$"),
    "Unescaped": re.compile(r"\\.?$"),
}


def unreadable(text: str, error: str, start: int = 0) -> Diagnostic:
    """Describe the error at which `tomllib` stopped, and what to do. `error` is its message, `start` the offset of the
    text."""
    lines = LineIndex(text)
    found = _MESSAGE.fullmatch(error)
    if not found:  # not from tomllib itself but from one of Python's limits
        message = "this file can't be read: nest brackets less deeply and use shorter numbers"
        return Diagnostic("syntax", Span(lines.start(0), lines.end(0)).shifted(start), message)
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
    unquoted = what.startswith("Invalid value") and _UNQUOTED.fullmatch(text, *span)
    shown = span.shifted(start)
    fixes = replace("Put it in quotes", shown, f'"{unquoted[0]}"') if unquoted else ()
    return Diagnostic("syntax", shown, advice or f"this is not valid TOML: {what[:1].lower()}{what[1:]}", fixes)
