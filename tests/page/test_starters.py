"""The small programs that the page offers to begin with."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, expect

from improv_core.page.routes import FOLDER
from improv_core.program.analysis import analyze
from improv_core.syntax.formatter import format_text
from tests.page.conftest import wait
from tests.page.editing import PLAYING, Edit

STARTERS = dict(
    re.findall(r'^    "([^"]+)",\n    `([^`]+)`', (FOLDER / "website" / "starters.js").read_text("utf-8"), re.MULTILINE)
)


@pytest.mark.parametrize("name", STARTERS)
def test_a_program_to_begin_with_has_no_problems_and_is_formatted(name: str) -> None:
    program = STARTERS[name]
    assert analyze(program).diagnostics == ()
    assert format_text(program) == program


@pytest.mark.slow("writes on the page of `improv edit`")
def test_a_puppet_can_be_chosen_played_and_undone(tmp_path: Path, window: BrowserContext) -> None:
    edited = Edit(tmp_path / "dance.improv", window)
    page = edited.page()
    text, before = page.locator("#text"), page.locator("#text").input_value()
    page.get_by_label("Try", exact=True).select_option("a puppet")
    expect(text).to_have_value(STARTERS["a puppet"])
    expect(page.get_by_label("Try", exact=True)).to_have_value("Try…")
    text.press("Control+Enter")
    wait(page, PLAYING)
    expect(page.locator("#bodies svg")).to_be_visible()
    text.press("Control+z")
    expect(text).to_have_value(before)
    edited.close()
