"""Lines of JSON that are messages of known types, read and written in small pieces. Standard library only.

`json.loads` and `json.dumps` let no other thread run before they end: too long for a process that has to stop robots,
or to show that it is alive.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from functools import lru_cache
from typing import Any, get_args

from improv_core.plain import message as in_plain_text
from improv_core.score.json_types import fits, hints_of, required_of


class ProtocolError(Exception):
    """A line is not a valid message here. The text is one plain line with the reason."""


def type_of(message: type[Any]) -> str:
    """Return the `type` of a kind of message."""
    return str(get_args(hints_of(message)["type"])[0])


def by_type(union: Any) -> dict[str, type]:
    """Return the messages of a union, or the one message, by `type`."""
    return {type_of(each): each for each in get_args(union) or [union]}


def read_as(line: bytes, union: Any) -> Any:
    """Return the message of a union that a line holds. Raises ProtocolError."""
    try:
        message = loads(line)
    except (ValueError, RecursionError):
        raise ProtocolError("this line is not JSON") from None
    kind = message.get("type") if isinstance(message, dict) else None
    if not isinstance(kind, str):
        raise ProtocolError("this line is JSON, but not a message: it has no `type`")
    expected = _by_type(union).get(kind)
    if expected is None:
        raise ProtocolError(in_plain_text(f"there is no message `{kind}`"))
    if missing := required_of(expected) - message.keys():
        raise ProtocolError(f"`{kind}` needs {' and '.join(f'`{name}`' for name in sorted(missing))}")
    hints = hints_of(expected)
    if wrong := [name for name in hints if name in message and not fits(message[name], hints[name])]:
        raise ProtocolError(f"`{wrong[0]}` of `{kind}` has a wrong value")
    return message


_by_type = lru_cache(by_type)

LONG = 10_000
"""The bytes from which a text takes a while to read."""
DEPTH = 3
"""The depth to which containers are opened: the rows of a score's movements are this deep, and so are its parts."""

_decode = json.JSONDecoder().raw_decode
_skip_white_space = re.compile(r"[ \t\n\r]*").match


def loads(line: bytes) -> Any:
    """Return the value of a JSON text, as `json.loads` reads it. Raises ValueError and RecursionError."""
    if len(line) <= LONG:
        return json.loads(line)
    text = line.decode()
    try:
        value, end = _value(text, _skip(text, 0), DEPTH)
    except IndexError:
        raise ValueError("the text is not complete") from None
    if _skip(text, end) != len(text):
        raise ValueError("something follows the value")
    return value


def dumps(value: Any) -> bytes:
    """Return the JSON text of a value, as `json.dumps` writes it."""
    return "".join(_pieces(value, DEPTH)).encode()


def _pieces(value: Any, depth: int) -> Iterator[str]:
    if not depth or not value or not isinstance(value, (dict, list)):
        yield json.dumps(value)
        return
    before = "{" if isinstance(value, dict) else "["
    for item in value:
        yield before
        if isinstance(value, dict):
            yield f"{json.dumps(item)}: "
        yield from _pieces(value[item] if isinstance(value, dict) else item, depth - 1)
        before = ", "
    yield "}" if isinstance(value, dict) else "]"


def _value(text: str, at: int, depth: int) -> tuple[Any, int]:
    """Return the value at an index, and the index after it."""
    if not depth or text[at] not in "{[":
        return _decode(text, at)
    at, closing = _skip(text, at + 1), "}" if text[at] == "{" else "]"
    pairs: list[tuple[str, Any]] = []
    items: list[Any] = []
    if text[at] == closing:
        return ({} if closing == "}" else []), at + 1
    while True:
        if closing == "}":
            _expect(text, at, '"')
            key, at = _decode(text, at)
            value, at = _value(text, _skip(text, _expect(text, _skip(text, at), ":")), depth - 1)
            pairs.append((key, value))
        else:
            value, at = _value(text, at, depth - 1)
            items.append(value)
        at = _skip(text, at)
        if text[at] == closing:
            return (dict(pairs) if closing == "}" else items), at + 1
        at = _skip(text, _expect(text, at, ","))


def _expect(text: str, at: int, what: str) -> int:
    if text[at] != what:
        raise ValueError(f"{what} is missing")
    return at + 1


def _skip(text: str, at: int) -> int:
    """Return the index of the first character after white space."""
    found = _skip_white_space(text, at)
    return found.end() if found else at
