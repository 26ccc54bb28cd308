"""The types of a page's messages, and the limits of its requests. `python -m tests.page_requests` writes both files
again."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from improv_core.protocol.decoding import by_type
from improv_core.protocol.editing import ProgramChange
from improv_core.protocol.fields import LAST_BEAT
from improv_core.protocol.page_messages import FromPage, Press, ToPage, fields_of
from improv_core.score.json_types import Between, hints_of, required_of

TYPES = Path(__file__).parent / "page" / "messages.d.ts"
LIMITS = Path(__file__).parent.parent / "improv_core" / "page" / "static" / "net" / "limits.js"
REQUESTS = {kind: message for kind, message in by_type(FromPage).items() if message is not Press}
NAMES = {str: "string", bool: "boolean", float: "number", int: "number", NoneType: "null", Any: "any"}


def types() -> str:
    """Return the types of all messages, for TypeScript's checks."""
    messages = "\n".join(f"  {kind}: {_shape(message)}" for kind, message in by_type(ToPage).items())
    requests = "".join(f"\n  | {_shape(each, fields_of(each))}" for each in REQUESTS.values())
    return (
        "// The messages that pages get, by type, and that they send. `python -m tests.page_requests` writes them\n"
        "// from the types in `improv_core/protocol/page_messages.py`.\n"
        f"interface Messages {{\n{messages}\n}}\n"
        "type Message = Messages[keyof Messages]\n"
        f"type PageRequest ={requests}\n"
    )


def limits() -> str:
    """Return the limits of the numbers in requests, for the page."""
    limited = REQUESTS | by_type(ProgramChange)
    rows = "\n".join(
        f"  {kind}: {{ {', '.join(found)} }}," for kind, each in limited.items() if (found := [*_limits(each)])
    )
    return (
        "// @ts-check\n"
        "// The least and most of the numbers in requests. Written by `python -m tests.page_requests`.\n"
        "\n"
        f"export const LIMITS = {{\n{rows}\n}}\n"
    )


def _shape(message: Any, fields: Container[str] | None = None) -> str:
    """Return an object with these fields, or with all."""
    shown = (
        f"{name}{'' if name in required_of(message) else '?'}: {_name(hint)}"
        for name, hint in hints_of(message).items()
        if fields is None or name in fields
    )
    return f"{{ {', '.join(shown)} }}"


def _name(hint: Any) -> str:
    """Return a type in TypeScript."""
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _name(arguments[0])
    if origin is Literal:
        return " | ".join(f'"{each}"' for each in arguments)
    if origin in (Union, UnionType):
        return " | ".join(map(_name, arguments))
    if origin is Mapping and arguments[1] is not Any:
        return f"Record<string, {_name(arguments[1])}>"
    if origin is Sequence:
        item = _name(arguments[0])
        return f"({item})[]" if "|" in item else f"{item}[]"
    return "any" if origin is Mapping else NAMES.get(hint) or _shape(hint)


def _limits(message: Any) -> Iterator[str]:
    for name, hint in hints_of(message).items():
        if get_origin(hint) is Annotated:
            for limit in get_args(hint)[1:]:
                if isinstance(limit, Between) and limit.most < LAST_BEAT:
                    yield f"{name}: [{limit.least:g}, {limit.most:g}]"


if __name__ == "__main__":
    TYPES.write_text(types(), encoding="utf-8")
    LIMITS.write_text(limits(), encoding="utf-8")
