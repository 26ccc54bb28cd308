"""Subjects of commits that the check of style accepts and refuses."""

from __future__ import annotations

import pytest

from tests.style import LONGEST_SUBJECT, wrong_subjects

RIGHT = (
    "Confirm stops from the leading stage",
    "Pass poses on",
    "Bring joints home",
    "Need no listener",
    "Test all orders",
)
WRONG = (
    "The stage confirms stops",
    "Confirms stops",
    "Confirmed stops",
    "Confirming stops",
    "test_stops waits",
    "Tests: x",
)


@pytest.mark.parametrize(("subject", "wrong"), [*((each, []) for each in RIGHT), *((each, [each]) for each in WRONG)])
def test_subjects_are_imperatives(subject: str, wrong: list[str]) -> None:
    refused = [f"begin with an imperative, such as Confirm: {each}" for each in wrong]
    assert [*wrong_subjects([subject])] == refused


def test_long_subjects_are_refused() -> None:
    assert [len([*wrong_subjects(["C" * length])]) for length in (LONGEST_SUBJECT, LONGEST_SUBJECT + 1)] == [0, 1]
