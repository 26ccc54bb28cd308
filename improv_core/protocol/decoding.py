"""Lines of JSON that are messages of known types. Standard library only."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, get_args

from improv_core.plain import message as in_plain_text
from improv_core.protocol.sliced_json import loads
from improv_core.score.fits import fits, hints_of, required_of


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
