"""A tapped tempo, written into a program."""

from __future__ import annotations

import pytest

from improv_core.ide.tempo import in_tempo
from improv_core.program.analysis import analyze
from tests.ide.cursor import applied


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("ada $ forward\n", "beat 96\nada $ forward\n"),
        ("# slow\nbar 3\nbeat 60 # a waltz\nada $ forward\n", "# slow\nbar 3\nbeat 96 # a waltz\nada $ forward\n"),
        ("beat\nada $ forward\n", "beat 96\nada $ forward\n"),
        ("", "beat 96\n"),
        ("# nothing yet", "# nothing yet\nbeat 96\n"),
        ("x = forward\nbeat 3/2\nada $ x\n", "x = forward\nbeat 96\nada $ x\n"),
    ],
)
def test_a_tempo_is_written_into_the_first_beat_line_or_above_all(before: str, after: str) -> None:
    text = applied(before, in_tempo(analyze(before), 96))
    assert text == after
    assert analyze(text).diagnostics == analyze(after).diagnostics
    assert analyze(text).tempo == 96
