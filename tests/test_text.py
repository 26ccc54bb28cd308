"""One edit that turns one text into another."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from improv_core.text import difference


@pytest.mark.parametrize(
    ("before", "after", "edit"),
    [
        ("forward left", "forward right", (8, 11, "righ")),
        ("left", "left left", (4, 4, " left")),
        ("left left", "left", (4, 9, "")),
        ("aaa", "aaaa", (3, 3, "a")),
        ("", "left", (0, 0, "left")),
        ("left", "left", (4, 4, "")),
    ],
)
def test_the_difference_of_two_texts_is_one_edit(before: str, after: str, edit: tuple[int, int, str]) -> None:
    assert difference(before, after) == edit


@given(st.text("ab\r\n"), st.text("ab\r\n"))
def test_the_edit_makes_the_other_text(before: str, after: str) -> None:
    start, end, text = difference(before, after)
    assert before[:start] + text + before[end:] == after
