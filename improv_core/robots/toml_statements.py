"""Reads a text that is not valid TOML one statement at a time, so that a wrong statement hides no other.

Such a text is only checked; it never plays.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import tomllib

from improv_core.diagnostics import Diagnostic
from improv_core.robots.toml_errors import DUPLICATE_KEY, DUPLICATE_SECTION, unreadable
from improv_core.robots.toml_positions import Keys, comments, find_positions, statements
from improv_core.slices import checkpoint
from improv_core.text import Span


@dataclass(slots=True)
class Readable:
    """The data of the valid statements, the errors of the others, and the tables that lack the data of those.

    Statements below an invalid header are left out, since it isn't known to which table they belong. If a key has two
    values, the first one counts.
    """

    data: dict[str, Any] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)
    broken: set[Keys] = field(default_factory=set)


def read_statements(text: str) -> Readable:
    """Read a text statement by statement. Never raises."""
    found = Readable()
    headers = {span.start: keys for span, keys in find_positions(text).headers}
    declared: set[Keys] = set()
    table: Keys | None = ()  # the table of the statement; None below an invalid header
    for start, statement in _pieces(text, sorted(headers)):
        checkpoint()
        header = headers.get(start)
        try:
            data = tomllib.loads(statement)
        except (ValueError, RecursionError) as error:
            found.diagnostics.append(unreadable(statement, str(error), start))
            if header is not None:
                found.broken |= {header, header[:-1]}
                table = None
            elif table is not None:
                found.broken.add(table)
            continue
        if header is not None:
            table, data = header, _below(data, header)
            if header in declared:
                found.diagnostics.append(Diagnostic("syntax", _first_line(start, statement), DUPLICATE_SECTION))
            declared.add(header)
        if table is not None and not _merge(_entered(found.data, table), data):
            found.diagnostics.append(Diagnostic("syntax", _first_line(start, statement), DUPLICATE_KEY))
    return found


def _pieces(text: str, headers: list[int]) -> Iterator[tuple[int, str]]:
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
