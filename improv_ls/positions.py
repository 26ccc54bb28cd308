"""The border to the editor's columns: the only place that knows UTF-8, UTF-16 and UTF-32."""

from __future__ import annotations

from typing import TypeAlias

from lsprotocol import types

from improv_core.text import LineIndex, Span

Encoding: TypeAlias = types.PositionEncodingKind | str


def to_position(lines: LineIndex, offset: int, encoding: Encoding) -> types.Position:
    """The editor's position of an offset."""
    line, column = lines.position(offset)
    return types.Position(line, units(lines.line(line)[:column], encoding))


def to_range(lines: LineIndex, span: Span, encoding: Encoding) -> types.Range:
    return types.Range(to_position(lines, span.start, encoding), to_position(lines, span.end, encoding))


def to_offset(lines: LineIndex, position: types.Position, encoding: Encoding) -> int:
    """The offset of an editor's position; beyond a line's end it means that end, inside a character its start."""
    if position.line >= len(lines.starts):
        return len(lines.text)
    text = lines.line(position.line)
    return lines.start(position.line) + _column(text, position.character, encoding)


def to_span(lines: LineIndex, place: types.Range, encoding: Encoding) -> Span:
    start, end = to_offset(lines, place.start, encoding), to_offset(lines, place.end, encoding)
    return Span(min(start, end), max(start, end))


def units(text: str, encoding: Encoding) -> int:
    """How many columns a text takes."""
    if text.isascii() or encoding == types.PositionEncodingKind.Utf32:
        return len(text)
    # A lone surrogate, which JSON can bring, must not raise.
    if encoding == types.PositionEncodingKind.Utf8:
        return len(text.encode("utf-8", "surrogatepass"))
    return len(text.encode("utf-16-le", "surrogatepass")) // 2


def _column(text: str, place: int, encoding: Encoding) -> int:
    if text.isascii() or encoding == types.PositionEncodingKind.Utf32:
        return min(place, len(text))
    for column, character in enumerate(text):
        place -= units(character, encoding)
        if place < 0:
            return column
    return len(text)
