"""Ctrl+Z on the page, after edits that the page has made for people."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.page.conftest import wait
from tests.page.editing import Edit

PROGRAM = "ada at 0 0\nada $ forward left\nbo $ left\n"


def cursor(page: Page) -> list[int]:
    """Return the beginning and the end of what is selected in the text."""
    found: list[int] = page.evaluate("(({ selectionStart, selectionEnd }) => [selectionStart, selectionEnd])(text)")
    return found


def put_cursor(page: Page, behind: str) -> list[int]:
    place = page.locator("#text").input_value().index(behind) + len(behind)
    page.locator("#text").focus()
    page.evaluate("place => text.setSelectionRange(place, place)", place)
    return [place, place]


def draw(page: Page) -> None:
    wait(page, "improv.handle && !improv.handle.text")
    page.locator("#draw").click()
    for _ in range(3):
        page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")


def perform(page: Page) -> None:
    page.locator("#perform").click()
    wait(page, "improv.drawn.ada.x === 0")  # at its start again, after a frame
    page.keyboard.down("ArrowUp")
    wait(page, "improv.drawn.ada.x > 1")
    page.keyboard.up("ArrowUp")
    page.keyboard.press("Enter")


def bend(page: Page) -> None:
    wait(page, "improv.handle?.text === 'forward'")
    page.keyboard.press("Alt+ArrowUp")
    page.keyboard.press("Alt+ArrowUp")
    expect(page.locator("#text")).to_have_value(PROGRAM.replace("forward", "forward 2.2m"))  # both have been written


@pytest.mark.slow("edits in a browser")
@pytest.mark.parametrize(("behind", "edits"), [("bo $ left\n", draw), ("ada $ fo", perform), ("ada $ fo", bend)])
def test_an_undo_puts_the_cursor_where_it_was_before_a_movement_by_hand(
    edit: Callable[[str], Edit], behind: str, edits: Callable[[Page], None]
) -> None:
    page = edit(PROGRAM).page()
    text = page.locator("#text")
    page.locator("#write").click()
    wait(page, "improv.transport.state === 'ended'")
    before = put_cursor(page, behind)
    edits(page)
    expect(text).not_to_have_value(PROGRAM)
    written = text.input_value()
    for redo in ("Control+Shift+z", None):
        page.keyboard.press("Control+z")
        expect(text).to_have_value(PROGRAM)
        assert cursor(page) == before
        if redo:
            page.keyboard.press(redo)
            expect(text).to_have_value(written)
            start, end = cursor(page)
            assert start == end


@pytest.mark.slow("draws in a browser")
def test_the_same_stroke_gives_the_same_words_after_each_undo(edit: Callable[[str], Edit]) -> None:
    page = edit(PROGRAM).page()
    put_cursor(page, "bo $ left\n")
    written = set[str]()
    for _ in range(3):
        draw(page)
        expect(page.locator("#text")).not_to_have_value(PROGRAM)
        written.add(page.locator("#text").input_value())
        page.locator("#draw").click()
        page.locator("#text").focus()
        page.keyboard.press("Control+z")
        expect(page.locator("#text")).to_have_value(PROGRAM)
    assert len(written) == 1


@pytest.mark.slow("edits in a browser")
def test_the_undo_of_a_phone_selects_nothing_so_the_next_word_replaces_nothing(edit: Callable[[str], Edit]) -> None:
    page = edit(PROGRAM).page()
    page.set_viewport_size({"width": 390, "height": 844})
    put_cursor(page, "bo $ left\n")
    draw(page)
    expect(page.locator("#text")).not_to_have_value(PROGRAM)
    page.evaluate("document.querySelector('#undo').click()")
    expect(page.locator("#text")).to_have_value(PROGRAM)
    page.evaluate("[...document.querySelectorAll('#word-always button')].at(-3).click()")
    expect(page.locator("#text")).to_have_value(f"{PROGRAM}rest ")


@pytest.mark.slow("edits in a browser")
def test_an_undo_puts_the_cursor_where_it_was_before_a_fix(edit: Callable[[str], Edit]) -> None:
    program = PROGRAM.replace("forward", "forwrd")
    page = edit(program).page()
    before = put_cursor(page, "bo $ left\n")
    page.locator("#diagnostics .fix").click()
    expect(page.locator("#text")).to_have_value(PROGRAM)
    page.keyboard.press("Control+z")
    expect(page.locator("#text")).to_have_value(program)
    assert cursor(page) == before

    page.keyboard.press("Control+a")  # what somebody selects and replaces is selected again
    page.keyboard.type("x")
    page.keyboard.press("Control+z")
    expect(page.locator("#text")).to_have_value(program)
    assert cursor(page) == [0, len(program)]
