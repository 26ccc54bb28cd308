"""A TOML text: its data, or why it is not valid, and the positions of its keys and values.

A text that is not valid is read without its wrong statements, so that they hide no other. Such a text is only checked;
it never plays.
"""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any

import tomllib

from improv_core.diagnostics import Diagnostic, replace
from improv_core.robots.toml_positions import Positions, find_positions, statements
from improv_core.slices import checkpoint
from improv_core.text import LineIndex, Span


@dataclass(frozen=True)
class TomlText:
    """The data of a text, and its positions.

    If the text is not valid TOML, there is no data, but there are the positions that can be found. `readable` is the
    data of its valid statements, in which other errors can be found.
    """

    text: str
    data: Mapping[str, Any] = field(default_factory=dict)
    diagnostics: tuple[Diagnostic, ...] = ()
    readable: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def positions(self) -> Positions:
        """Positions, found when they are first needed: a program whose file has no errors needs none."""
        return find_positions(self.text)


@lru_cache(maxsize=4)
def read_toml(text: str) -> TomlText:
    """Read a text. Never raises; invalid TOML gives a `syntax` diagnostic at its position."""
    text = re.sub("^\ufeff", " ", text)  # a byte order mark; the space keeps the offsets
    try:
        data = _loads(text)
    except (ValueError, RecursionError) as error:
        return _partly_read(text, str(error))
    return TomlText(text, data, readable=data)


def _loads(text: str) -> dict[str, Any]:
    """Return the data of a text. Raises ValueError and RecursionError."""
    if any(line.count(".") > MAX_DOTS for line in text.split("\n")):
        raise RecursionError("the time and memory that tomllib takes grow with the square of the names in a key")
    return tomllib.loads(text)


def _partly_read(text: str, error: str) -> TomlText:
    """Read the valid statements of a text, and report the others: those that are wrong by themselves, and those that
    repeat a key or a section. `tomllib` stopped at this error."""
    diagnostics: list[Diagnostic] = []
    headers = [span.start for span, _ in find_positions(text).headers]
    places, heads, left = list[int](), list[bool](), list[str]()
    is_lost = False  # below a wrong header, nobody knows to which table a statement belongs
    for start, statement in statements(text):
        checkpoint()
        places.append(start)
        heads.append(bisect_left(headers, start) < bisect_left(headers, start + len(statement)))
        is_lost = is_lost and not heads[-1]
        left.append(_NO_LINE_END.sub(" ", statement) if is_lost else statement)
        try:
            _loads(statement)
        except (ValueError, RecursionError) as wrong:
            diagnostics.append(unreadable(statement, str(wrong), start))
            left[-1] = _NO_LINE_END.sub(" ", statement)
            is_lost = is_lost or heads[-1]
    for _ in range(MAX_REPEATED + 1):
        try:
            readable = _loads("".join(left))
        except (ValueError, RecursionError) as wrong:
            diagnostics.append(unreadable("".join(left), str(wrong)))
            first = bisect_right(places, diagnostics[-1].span.start) - 1
            last = first + 1
            while heads[first] and last < len(left) and not heads[last]:
                last += 1
            left[first:last] = [_NO_LINE_END.sub(" ", each) for each in left[first:last]]
            continue
        return TomlText(text, {}, tuple(diagnostics) or (unreadable(text, error),), readable)
    return TomlText(text, {}, tuple(diagnostics))


_NO_LINE_END = re.compile(r"[^\n]")
MAX_DOTS = 1000
"""The most dots in a line that is read."""
MAX_REPEATED = 3
"""The most repeated keys and sections that are reported. After them, nothing else in the text is read."""
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
    """Describe the error at which `tomllib` stopped, and what to do. `start` is the offset of the text."""
    lines = LineIndex(text)
    found = _MESSAGE.fullmatch(error)
    if not found:  # not from tomllib itself but from one of Python's limits
        message = "this file can't be read: nest brackets less deeply, and use shorter keys and numbers"
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
        span = Span(begin.start(), at + len(text[at:]) - len(text[at:].lstrip("]")))
    unquoted = what.startswith("Invalid value") and _UNQUOTED.fullmatch(text, *span)
    shown = span.shifted(start)
    fixes = replace("Put it in quotes", shown, f'"{unquoted[0]}"') if unquoted else ()
    return Diagnostic("syntax", shown, advice or f"this is not valid TOML: {what[:1].lower()}{what[1:]}", fixes)
