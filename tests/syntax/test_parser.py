"""Trees of statements are cached, up to a limit."""

from __future__ import annotations

from improv_core.syntax.parser import Kept


def test_the_statements_used_last_are_kept_up_to_a_number_of_characters() -> None:
    kept = Kept(most=30)
    first, second = kept.get("r $ forward"), kept.get("r $ left")
    assert kept.get("r $ forward") is first
    kept.get("r $ right left")
    assert kept.get("r $ forward") is first
    assert kept.get("r $ left") is not second


def test_a_statement_longer_than_all_that_is_kept_is_parsed_all_the_same() -> None:
    assert Kept(most=3).get("r $ forward").body
