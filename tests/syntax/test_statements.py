"""The beginnings and ends of statements."""

from __future__ import annotations

import pytest

from improv_core.syntax.statements import split


@pytest.mark.parametrize(
    ("text", "statements"),
    [
        ("beat 60\nr $ forward", ["beat 60", "r $ forward"]),
        ("r $ (forward\n  left)\nbeat 60", ["r $ (forward\n  left)", "beat 60"]),
        ("r $ [forward\r\n\r\n left]\r\n", ["r $ [forward\r\n\r\n left]"]),
        ("x = left\ry = right", ["x = left", "y = right"]),
        ("\ufeffbeat 60", ["beat 60"]),
        ("# only a comment\n\n   \n", []),
        ("r $ forward # why = $ (\nbeat 60", ["r $ forward # why = $ (", "beat 60"]),
        ("x = left # \u2028 y = right", ["x = left # \u2028 y = right"]),
        ("x = left \f y", ["x = left \f y"]),
        # One missing bracket never swallows the rest.
        ("x = (forward\ny = left", ["x = (forward", "y = left"]),
        ("x = (forward\nr1 r2 $ left", ["x = (forward", "r1 r2 $ left"]),
        ("x = [forward\n  beat 60", ["x = [forward", "beat 60"]),
        ("x = (forward\n  left\ny = left", ["x = (forward\n  left", "y = left"]),
        ("x = (forward\nbeat\n)", ["x = (forward\nbeat\n)"]),
        ("x = forward)\ny = left", ["x = forward)", "y = left"]),
        ("f n (m)=(forward\ng(m) = m", ["f n (m)=(forward", "g(m) = m"]),
        # A line that begins with `||` or `else` continues the statement.
        ("r $ a\n  || b\nbeat 60", ["r $ a\n  || b", "beat 60"]),
        ("r $ a # why\n\n# because\n|| b # so\n# done\n", ["r $ a # why\n\n# because\n|| b # so"]),
        ("r $ if near a\nelse b\nelsewhere = a", ["r $ if near a\nelse b", "elsewhere = a"]),
        ("r $ a ||\nb", ["r $ a ||", "b"]),
        ("|| a", ["|| a"]),
        # A line of dashes is a statement of its own.
        ("r $ (a\n---\nr $ b\n  ----- # two\n", ["r $ (a", "---", "r $ b", "----- # two"]),
        ("--\n--- a", ["--", "--- a"]),
    ],
)
def test_a_text_is_split_into_statements(text: str, statements: list[str]) -> None:
    found = list(split(text))
    assert [piece for _, piece in found] == statements
    assert all(text[start : start + len(piece)] == piece for start, piece in found)
