"""Errors in a text that is not valid TOML: their positions, and what to do."""

from __future__ import annotations

import re

from improv_core.diagnostics import Diagnostic, replace
from improv_core.text import LineIndex, Span

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
