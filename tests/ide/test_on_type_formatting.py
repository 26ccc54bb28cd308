"""Lines that continue inside brackets: the program after a key, and the new spaces before the cursor."""

from __future__ import annotations

import pytest

from improv_core.diagnostics import applied
from improv_core.ide.on_type_formatting import indent
from improv_core.program.analysis import analyze
from tests.ide.cursor import CURSOR


def check(before: str, after: str) -> None:
    text = before.replace(CURSOR, "")
    assert applied(text, list(indent(analyze(text), before.index(CURSOR)))) == after


def check_stays(program: str) -> None:
    check(program, program.replace(CURSOR, ""))


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_a_line_inside_brackets_is_indented_by_those_that_are_open(end: str) -> None:
    check(f"r $ ({end}|>", f"r $ ({end}  ")
    check(f"r $ repeat 4 [forward (left{end}|>right)]", f"r $ repeat 4 [forward (left{end}    right)]")
    check(f"r $ (left  # 🐢 ({end}\t|>up)", f"r $ (left  # 🐢 ({end}  up)")
    check(f"r $ (up){end}s $ (up{end}|>{end}", f"r $ (up){end}s $ (up{end}  {end}")


def test_a_closing_bracket_that_begins_a_line_is_indented_like_its_opening_line() -> None:
    check("r $ (\n  up\n  )|>", "r $ (\n  up\n)")
    check("r $ ([\n    up\n    ]|>", "r $ ([\n    up\n  ]")
    check("r $ ([\n    up\n  ] )|>", "r $ ([\n    up\n] )")
    check_stays("r $ (\n  up)|>")
    check_stays("r $ (\n      up\n      left)|>")


def test_the_line_after_a_broken_bracket_is_indented_like_the_statement() -> None:
    check("r $ (\n  up)\n  |>", "r $ (\n  up)\n")
    check(" r $ (\n   up)\n   |>\ns $ up", " r $ (\n   up)\n \ns $ up")


def test_lines_outside_brackets_keep_their_indentation() -> None:
    for program in ("|>", "  |>", "r $ up\n  |>", "r $ (\n  up)\n\n  |>"):
        check_stays(program)
    check_stays("r $ (up\n   x = |>left")
    check_stays("r $ (up\n   |>s $ up")
    check_stays("r $ (\n  |>")
    check_stays("r $ (up\n   left |>right)")
