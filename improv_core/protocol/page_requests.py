"""Reads the requests of a page. It checks every value, and drops everything that does not fit."""

from __future__ import annotations

import json
from typing import Any, cast

from improv_core.protocol.commands import Added
from improv_core.protocol.decoding import by_type
from improv_core.protocol.page_messages import FromPage
from improv_core.score.fits import fits, hints_of

_REQUESTS: dict[str, Any] = by_type(FromPage)


def fields_of(message: Any) -> set[str]:
    """Return the fields of a request that a page may send."""
    return hints_of(message).keys() - hints_of(Added).keys()


def read(text: str) -> FromPage | None:
    """Return the request in a message, without values that only Improv itself may add, or None."""
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        return None
    kind = message.get("type") if isinstance(message, dict) else None
    expected = _REQUESTS.get(kind) if isinstance(kind, str) else None
    if expected is None:
        return None
    request = {name: value for name, value in message.items() if name in fields_of(expected)}
    return cast(FromPage, request) if fits(request, expected) else None
