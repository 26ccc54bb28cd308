"""The fixes that can be applied with every save, and their effect on a program."""

from __future__ import annotations

import pytest

from improv_core.diagnostics import applied
from improv_core.ide.code_action import fix_all
from improv_core.program.analysis import analyze
from improv_core.program.compiler import compiled


def fixed(program: str) -> str:
    """Return the program after all safe fixes."""
    return applied(program, [edit for action in fix_all(analyze(program)) for edit in action.edits])


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("r $ left, up, left\ns $ up | left\n", "r $ left up left\ns $ up || left\n"),
        ("r, s $ left\n--\nr: up\n", "r s $ left\n---\nr $ up\n"),
        ("tempo 60\nr $ left\nbeat 60\n", "beat 60\nr $ left\n"),
        ("p n = repeat n left\nr $ p (3) | up\n", "p n = repeat n left\nr $ p 3 || up\n"),
    ],
)
def test_unambiguous_slips_are_fixed(before: str, after: str) -> None:
    assert fixed(before) == after


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("r $ fast 1 scale 1 (left up)\n", "r $   (left up)\n"),
        ("r $ canon 2 left\n---\n---\nr $ chance 1/2 up\n---\n", "r $  left\n---\nr $ chance 1/2 up\n"),
    ],
)
def test_words_without_effect_are_removed_and_nothing_else_changes(before: str, after: str) -> None:
    assert fixed(before) == after
    one, other = (compiled(analyze(text), 20)["robots"] for text in (before, after))
    assert one == other


@pytest.mark.parametrize(
    "program",
    [
        "r $ shuffle left chance 1/2 up\n",  # without the throw of `shuffle`, the other one falls differently
        "r $ (up || seed 2 left) chance 1/2 up\n",  # without `seed`, the `||` takes no throw
        "x = fast 1 (left up)\nr $ seed 3 choose x\n",  # somebody is about to use the name
        "r $ left up || forward\nx = left\n",  # somebody is about to use it
        "beat 60\nr $ left\nbeat 90\n",  # the other one may be meant
        "r $ slow 1,5 left\n",  # a decimal point, or two numbers?
        "r $ fowrard (left\n",
    ],
)
def test_ambiguous_slips_are_left_alone(program: str) -> None:
    assert fix_all(analyze(program)) == []
