"""Robots and profiles in an improv.toml: found, with all their names, and renamed."""

from __future__ import annotations

import pytest

from improv_core.ide.rename import RefusalError
from improv_core.ide.robots_file.references import declarations, rename_profile, symbol_at, uses
from tests.ide.cursor import applied

TEXT = """\
[profiles.rover]
step = 0.5
[profiles.fast]
base = "rover"
[robots.anna]
profile = 'rover'
[robots.bert]
profile = "husky"
[robots.anna.start]
x = 1
"""


def check(word: str, expected: str, nth: int = 0) -> None:
    """The lines of all names of what the cursor is in; a use is in brackets."""
    offset = -1
    for _ in range(nth + 1):
        offset = TEXT.index(word, offset + 1)
    symbol = symbol_at(TEXT, offset + 1)
    assert symbol
    declared = [str(TEXT.count("\n", 0, span.start)) for span in declarations(TEXT, symbol)]
    used = [f"({TEXT.count(chr(10), 0, span.start)})" for span in uses(TEXT, symbol)]
    assert " ".join([symbol.section, symbol.name, *declared, *used]) == expected


def test_all_names_of_a_robot_or_profile() -> None:
    check("rover", "profiles rover 0 (3) (5)")
    check("rover", "profiles rover 0 (3) (5)", nth=2)
    check("anna", "robots anna 4 8")
    check("husky", "profiles husky (7)")
    assert symbol_at(TEXT, TEXT.index("step")) is None


def renamed(text: str, word: str, new: str) -> str:
    symbol = symbol_at(text, text.index(word))
    assert symbol
    return applied(text, rename_profile(text, symbol, new))


def test_a_profile_is_renamed_with_its_uses() -> None:
    assert renamed(TEXT, "rover", "cart") == TEXT.replace("rover", "cart")
    assert renamed(TEXT, "rover", "rover") == TEXT


@pytest.mark.parametrize(
    ("text", "word", "new", "why"),
    [
        (TEXT, "rover", "husky", "`husky` is already a profile: choose another name"),
        (TEXT, "rover", "fast", "`fast` is already a profile: choose another name"),
        (TEXT, "rover", "a b", "`a b` is not a valid profile name: use a to z, digits, `_`, and `-`"),
        (TEXT, "husky", "a", "`husky` is built in and can't be renamed"),
        (TEXT + "[", "rover", "a", "improv.toml can't be read: fix it first"),
    ],
)
def test_a_rename_that_is_refused(text: str, word: str, new: str, why: str) -> None:
    with pytest.raises(RefusalError) as refusal:
        renamed(text, word, new)
    assert str(refusal.value) == why
