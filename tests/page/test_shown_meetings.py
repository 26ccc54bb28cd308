"""Meetings are marked on the stage, and a click goes to that beat. modules/meetings.test.js tests the marks."""

from __future__ import annotations

from collections.abc import Callable

from playwright.sync_api import Page, expect

from tests.page.conftest import Commands, Keep, asked, at, wait
from tests.page.looks import PIXEL

MARK = "201,42,42"


def test_a_click_on_a_mark_seeks_there(still: Callable[..., Page], commands: Commands, keep: Keep) -> None:
    page = still("ada at -4 0\nbo at 4 0 facing 180\nada bo $ repeat 4 forward\n")
    button = page.get_by_role("button", name="1 meeting ahead")
    expect(button).to_be_visible()  # as the server has found by now
    mark = at(page, 0, 0)
    page.reload()
    wait(page, f"({PIXEL})(0.03, 0) === '{MARK}'")  # beside its exclamation point
    page.mouse.move(*mark)
    keep(page, "page-meetings.png")
    page.mouse.click(*mark)
    seek = asked(commands)
    assert seek["type"] == "seek"
    assert 1.5 < seek["beat"] < 2
    page.mouse.down()
    page.mouse.move(mark[0] + 60, mark[1], steps=3)
    page.mouse.up()  # the view was moved: no click
    button.click()
    assert asked(commands) == seek
