"""The carets of `improv check`: under the place, in any line."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.commands.excerpt import excerpt
from improv_core.text import LineIndex, Span


@pytest.mark.parametrize(
    ("text", "mark", "expected"),
    [
        ("r $ foward left", "foward", "r $ foward left\n    ^^^^^^"),
        ("\tr $\tfoward", "foward", "    r $    foward\n           ^^^^^^"),
        ("# 世界\nr $ 世界 日本 left", "日本", "r $ 世界 日本 left\n         ^^^^"),
        ("r $ e\u0301a\u0300 up", "up", "r $ e\u0301a\u0300 up\n       ^^"),
        ("r $ (\r\n  left\r\n) ]\r\n", "left\r\n)", "  left\n  ^^^^"),
        ("r $ \x1b[31m up", "up", "r $ \\x1b[31m up\n             ^^"),
        ("r $ \u202eup left", "left", "r $ \\u202eup left\n             ^^^^"),
        (f"r $ {'left ' * 40}foward{' right' * 40}", "foward", "…left left foward right rig…\n           ^^^^^^"),
        (f"r $ {'left ' * 40}foward", "foward", "…left left left left foward\n                     ^^^^^^"),
        (f"foward{' right' * 40}", "foward", "foward right right right r…\n^^^^^^"),
        ("r $ " + "x" * 90, "x" * 90, "r $ xxxxxxxxxxxxxxxxxxx…\n    ^^^^^^^^^^^^^^^^^^^"),
    ],
)
def test_the_carets_are_under_the_place(text: str, mark: str, expected: str) -> None:
    start = text.index(mark)
    assert "\n".join(excerpt(LineIndex(text), Span(start, start + len(mark)), 26)) == expected


def test_an_empty_place_has_one_caret() -> None:
    assert excerpt(LineIndex("r $"), Span(3, 3), 26) == ("r $", "   ^")


@given(st.text(), st.integers(0, 50), st.integers(0, 50), st.integers(10, 60))
def test_any_text_fits_and_is_printable(text: str, start: int, length: int, room: int) -> None:
    line, carets = excerpt(LineIndex(text), Span(start, start + length), room)
    assert line.isprintable()
    assert carets.strip(" ").strip("^") == ""
    assert len(carets) <= room + len("…^")
