"""Requests of a page, for its JavaScript. `python -m tests.page_requests` writes that file again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, get_args, get_origin

from improv_core.protocol.decoding import by_type
from improv_core.protocol.editing import ProgramChange
from improv_core.protocol.fields import LAST_BEAT
from improv_core.protocol.page_messages import FromPage, Press, fields_of
from improv_core.score.fits import Between, hints_of, required_of

FILE = Path(__file__).parent.parent / "improv_core" / "page" / "static" / "net" / "requests.js"
REQUESTS = {kind: message for kind, message in by_type(FromPage).items() if message is not Press}
NAMES = {str: "string", bool: "boolean", float: "number", int: "number", NoneType: "null"}


def text() -> str:
    """Return the whole file."""
    union = "\n *   | ".join(map(_shape, REQUESTS.values()))
    limited = REQUESTS | by_type(ProgramChange)
    limits = "\n".join(
        f"  {kind}: {{ {', '.join(found)} }}," for kind, each in limited.items() if (found := [*_limits(each)])
    )
    return (
        "// @ts-check\n"
        "// Requests of a page, and the least and most of their numbers. Written by `python -m tests.page_requests`\n"
        "// from the types in commands.py, editing.py, and messages.py.\n"
        "\n"
        "/** @typedef {{ x: number, y: number, heading: number }} StartPose in meters and degrees */\n"
        f"/**\n * @typedef {{{union}}} Request\n */\n"
        "\n"
        f"export const LIMITS = {{\n{limits}\n}}\n"
    )


def _shape(message: Any) -> str:
    maybe = {True: "", False: "?"}
    fields = (
        f"{name}{maybe[name in required_of(message)]}: {_name(hint)}"
        for name, hint in hints_of(message).items()
        if name in fields_of(message)
    )
    return f"{{ {', '.join(fields)} }}"


def _name(hint: Any) -> str:
    """Return a type in JSDoc."""
    origin, arguments = get_origin(hint), get_args(hint)
    if origin is Annotated:
        return _name(arguments[0])
    if origin is Literal:
        return " | ".join(f'"{each}"' for each in arguments)
    if origin is UnionType:
        return " | ".join(map(_name, arguments))
    if origin is Mapping:
        return f"Record<string, {_name(arguments[1])}>"
    if origin is Sequence:
        return f"{_name(arguments[0])}[]"
    if hasattr(hint, "__required_keys__") and "type" in hints_of(hint):
        return _shape(hint)
    return NAMES.get(hint) or hint.__name__.removesuffix("Json")


def _limits(message: Any) -> Iterator[str]:
    for name, hint in hints_of(message).items():
        if get_origin(hint) is Annotated:
            for limit in get_args(hint)[1:]:
                if isinstance(limit, Between) and limit.most < LAST_BEAT:
                    yield f"{name}: [{limit.least:g}, {limit.most:g}]"


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
