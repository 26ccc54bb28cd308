"""Subjects of commits that the check of style accepts and refuses."""

from __future__ import annotations

import pytest

from tests.style import LONGEST_SUBJECT, wrong_subjects


@pytest.mark.parametrize(
    "subject",
    [
        "Confirm stops from the leading stage",
        "Pass poses on",
        "Bring joints home",
        "Need no listener",
        "Test all orders",
    ],
)
def test_imperatives_pass(subject: str) -> None:
    assert [*wrong_subjects([subject])] == []


@pytest.mark.parametrize(
    "subject",
    [
        "The stage confirms stops",
        "Confirms stops",
        "Confirmed stops",
        "Confirming stops",
        "test_stops waits",
        "Tests: waits",
    ],
)
def test_other_forms_are_refused(subject: str) -> None:
    assert [*wrong_subjects([subject])] == [f"begin with an imperative, such as Confirm: {subject}"]


def test_long_subjects_are_refused() -> None:
    assert [len([*wrong_subjects(["C" * length])]) for length in (LONGEST_SUBJECT, LONGEST_SUBJECT + 1)] == [0, 1]
