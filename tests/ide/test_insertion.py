"""Words for a gesture: before, the cursor `|>`; after, the program with the words."""

from __future__ import annotations

import pytest

from improv_core.diagnostics import applied
from improv_core.ide.insertion import gap_at
from tests.ide.cursor import at_cursor


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("ada $ for|>ward 2.2m left", "ada $ forward 2.2m rest left"),
        ("ada $ |>forward left", "ada $ forward rest left"),
        ("ada $ forward left 9|>0deg radius 1m", "ada $ forward left 90deg radius 1m rest"),
        ("ada $ repeat 2 (forward left|>)", "ada $ repeat 2 (forward left rest)"),
        ("ada $ forward |> left", "ada $ forward rest left"),
    ],
)
def test_words_stand_behind_the_word_at_the_cursor_and_its_measures(before: str, after: str) -> None:
    analysis, offset = at_cursor(before)
    gap = gap_at(analysis, offset)
    assert gap
    assert " ".join(applied(analysis.text, [gap.filled("rest")]).split()) == after
