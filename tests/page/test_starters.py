"""The small programs that the page offers to begin with."""

from __future__ import annotations

import re

import pytest

from improv_core.page.files import FOLDER
from improv_core.program.analysis import analyze
from improv_core.syntax.formatter import format_text

STARTERS = dict(
    re.findall(r'^    "([^"]+)",\n    `([^`]+)`', (FOLDER / "website" / "starters.js").read_text("utf-8"), re.MULTILINE)
)


@pytest.mark.parametrize("name", STARTERS)
def test_a_program_to_begin_with_has_no_problems_and_is_formatted(name: str) -> None:
    program = STARTERS[name]
    assert analyze(program).diagnostics == ()
    assert format_text(program) == program
