"""The editor's columns: the only module that knows UTF-8, UTF-16 and UTF-32."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

from lsprotocol import types

from improv_core.text import LineIndex, Span

if TYPE_CHECKING:
    from improv_core.ide.rehearsal import Scenes

Encoding: TypeAlias = types.PositionEncodingKind | str


def to_position(lines: LineIndex, offset: int, encoding: Encoding) -> types.Position:
    """Convert an offset to the editor's position."""
    return types.Position(**_json_position(lines, offset, encoding))


def json_range(lines: LineIndex, span: Span, encoding: Encoding) -> dict[str, dict[str, int]]:
    """Return the JSON of a range."""
    return {
        "start": _json_position(lines, span.start, encoding),
        "end": _json_position(lines, span.end, encoding),
    }


def _json_position(lines: LineIndex, offset: int, encoding: Encoding) -> dict[str, int]:
    line, column = lines.position(offset)
    start = lines.starts[line]
    return {"line": line, "character": units(lines.text[start : start + column].removesuffix("\r"), encoding)}


def to_range(lines: LineIndex, span: Span, encoding: Encoding) -> types.Range:
    return types.Range(to_position(lines, span.start, encoding), to_position(lines, span.end, encoding))


def to_offset(lines: LineIndex, position: types.Position, encoding: Encoding) -> int:
    """Convert an editor's position to an offset. Beyond a line's end it is that end, inside a character its start."""
    if position.line >= len(lines.starts):
        return len(lines.text)
    text = lines.line(position.line)
    return lines.start(position.line) + _column(text, position.character, encoding)


def range_of(value: Any) -> types.Range | None:
    """Return the range in a command's argument; None if it is not a range."""
    try:
        places = [(place["line"], place["character"]) for place in (value["start"], value["end"])]
    except (KeyError, TypeError):
        return None
    if not all(type(number) is int and number >= 0 for place in places for number in place):
        return None
    return types.Range(*(types.Position(*place) for place in places))


def to_span(lines: LineIndex, range_: types.Range, encoding: Encoding) -> Span:
    start, end = to_offset(lines, range_.start, encoding), to_offset(lines, range_.end, encoding)
    return Span(min(start, end), max(start, end))


def units(text: str, encoding: Encoding) -> int:
    """Return the number of columns that a text takes up."""
    if text.isascii() or encoding == types.PositionEncodingKind.Utf32:
        return len(text)
    # JSON can contain a lone surrogate, which must not raise.
    if encoding == types.PositionEncodingKind.Utf8:
        return len(text.encode("utf-8", "surrogatepass"))
    return len(text.encode("utf-16-le", "surrogatepass")) // 2


def _column(text: str, character: int, encoding: Encoding) -> int:
    if text.isascii() or encoding == types.PositionEncodingKind.Utf32:
        return min(character, len(text))
    for column, each in enumerate(text):
        character -= units(each, encoding)
        if character < 0:
            return column
    return len(text)


def to_scenes(scenes: Scenes) -> Mapping[str, int]:
    """Convert scenes to an argument of `improv.play`, counted from 1."""
    return {"from": scenes.first + 1, "to": scenes.last + 1}


def scenes_of(value: object) -> tuple[str | int | None, str | int | None] | None:
    """Return the first and the last scene of such an argument, by name or number; None if it is none."""
    if not isinstance(value, dict) or not value or not value.keys() <= {"from", "to"}:
        return None
    first, last = value.get("from"), value.get("to")
    return (first, last) if all(each is None or type(each) in (int, str) for each in (first, last)) else None
