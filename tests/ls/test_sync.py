"""Document sync: after any edit, in any unit, our text is the editor's text."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lsprotocol import types
from lsprotocol.types import PositionEncodingKind as Encoding

from improv_core.text import LineIndex
from improv_ls.documents import changed, opened
from improv_ls.positions import to_offset, to_position

URI = "untitled:dance"
ENCODINGS = [Encoding.Utf8, Encoding.Utf16, Encoding.Utf32]
UNITS = {Encoding.Utf8: ("utf-8", 1), Encoding.Utf16: ("utf-16-le", 2), Encoding.Utf32: ("utf-32-le", 4)}
"""Codec that writes a text in units of this many bytes."""
CHARACTERS = [*"a( é語😀", "👩‍🚀", "\n", "\r", "\r\n", "\f", "\v", "\u2028", "\x85", "\x1c", "\ufeff"]
texts = st.lists(st.sampled_from(CHARACTERS), max_size=25).map("".join)


class Editor:
    """A text as an editor keeps it: lines of units, edited by line and column alone."""

    def __init__(self, text: str, encoding: Encoding) -> None:
        self._codec, self._size = UNITS[encoding]
        self.lines = self._split(text)

    @property
    def text(self) -> str:
        return "".join(self.lines)

    def replace(self, start: types.Position, end: types.Position, text: str) -> None:
        before = "".join(self.lines[: start.line]) + self._units(self.lines[start.line], 0, start.character)
        after = self._units(self.lines[end.line], end.character, None) + "".join(self.lines[end.line + 1 :])
        self.lines = self._split(before + text + after)

    def places(self) -> list[types.Position]:
        """Return every place of a cursor: between characters, and not between \r and \n."""
        found = []
        for number, line in enumerate(self.lines):
            body = line.rstrip("\r\n")
            columns = {self._length(body[:column]) for column in range(len(body) + 1)}
            found += [types.Position(number, column) for column in sorted(columns)]
        return found

    def _split(self, text: str) -> list[str]:
        lines, line = [], ""
        for place, character in enumerate(text):
            line += character
            if character == "\n" or (character == "\r" and text[place + 1 : place + 2] != "\n"):
                lines.append(line)
                line = ""
        return [*lines, line]

    def _length(self, text: str) -> int:
        return len(text.encode(self._codec)) // self._size

    def _units(self, line: str, start: int, end: int | None) -> str:
        coded = line.encode(self._codec)
        return coded[start * self._size : None if end is None else end * self._size].decode(self._codec)


@pytest.mark.parametrize("encoding", ENCODINGS)
@given(data=st.data())
def test_the_server_has_the_same_text_as_the_editor(encoding: Encoding, data: st.DataObject) -> None:
    text = data.draw(texts)
    editor, document = Editor(text, encoding), opened(URI, 1, text)
    for version in range(2, 2 + data.draw(st.integers(1, 3))):
        events: list[types.TextDocumentContentChangeEvent] = []
        # Several changes in one event: each applies to what the one before has left, and they may overlap.
        for _ in range(data.draw(st.integers(1, 3))):
            places = editor.places()
            one, other = data.draw(st.sampled_from(places)), data.draw(st.sampled_from(places))
            start, end = sorted((one, other), key=lambda place: (place.line, place.character))
            put = data.draw(texts)
            editor.replace(start, end, put)
            events.append(types.TextDocumentContentChangePartial(range=types.Range(start, end), text=put))
        document = changed(document, version, events, encoding)
        assert document.lines.text == editor.text
        assert document.lines.starts == LineIndex(editor.text).starts


@pytest.mark.parametrize("encoding", ENCODINGS)
@given(text=texts)
def test_positions_convert_back_to_their_offsets(encoding: Encoding, text: str) -> None:
    lines = LineIndex(text)
    for offset in range(len(text) + 1):
        if text[offset - 1 : offset + 1] != "\r\n":
            assert to_offset(lines, to_position(lines, offset, encoding), encoding) == offset


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_positions_past_a_line_or_inside_a_character_move_to_its_edge(encoding: Encoding) -> None:
    lines = LineIndex("a😀\nb")
    assert to_offset(lines, types.Position(0, 99), encoding) == 2
    assert to_offset(lines, types.Position(9, 0), encoding) == 4
    if encoding is not Encoding.Utf32:
        assert to_offset(lines, types.Position(0, 2), encoding) == 1


def test_lone_surrogates_of_json_do_no_harm() -> None:
    document = opened(URI, 1, "r $ \ud83d left \udc00\n")
    assert to_position(document.lines, 7, Encoding.Utf16).character == 7
    assert to_offset(document.lines, types.Position(0, 8), Encoding.Utf8) == 6
