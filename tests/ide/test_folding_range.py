"""Folding: the lines that fold into the first one are drawn beside the program."""

from __future__ import annotations

from textwrap import dedent

from improv_core.ide.folding_range import folds
from improv_core.program.analysis import analyze


def check(program: str, *expected: str) -> None:
    text = dedent(program).strip("\n")
    assert [f"{fold.first}-{fold.last} {fold.kind}" for fold in folds(analyze(text))] == list(expected)


def test_brackets_fold_and_keep_their_closing_line_in_sight() -> None:
    check("x = repeat 2 (\n  up\n  left\n)\nr $ x", "0-2 code")
    check("x = (up\n  left)\nr $ x", "0-1 code")
    check("r $ (\n  up\n  [\n    left\n    down\n  ]\n)", "0-5 code", "2-4 code")
    check("r $ (\n)", *[])


def test_comments_and_scenes_fold() -> None:
    check("# one\n  # two\n\n# alone\nr $ (up # no\n# yes\n# yes\n)", "0-1 comment", "4-6 code", "5-6 comment")
    check("# one\r# two\r\n# three", "0-2 comment")
    check("r $ up\n---\nr $ (\n  up\n)\n\n  --- # two\nr $ left", "1-4 code", "2-3 code", "6-7 code")
    check("---\n---\n# one\n# two\n", "1-3 code", "2-3 comment")
