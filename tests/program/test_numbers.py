"""Which numbers words take, up to their limits."""

from __future__ import annotations

import pytest

from improv_core.program.analysis import analyze


@pytest.mark.parametrize(
    ("word", "numbers", "wrong"),
    [
        ("chance", ["1/1000", "0.5", "1"], ["0", "1.001", "3/2"]),
        ("fast", ["1/1000", "1", "4"], ["0"]),
        ("repeat", ["0", "1", "7", "4/2"], ["1/2", "1.5"]),
        ("seed", ["0.5", "7"], ["0"]),
    ],
)
def test_a_word_takes_numbers_up_to_its_limits_and_no_others(word: str, numbers: list[str], wrong: list[str]) -> None:
    refused = [number for number in numbers + wrong if not analyze(f"r $ {word} {number} left").ok]
    assert refused == wrong
