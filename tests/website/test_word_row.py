"""Undo and words to tap above the keyboard of a phone."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Browser, expect

from tests.page.conftest import Keep, new_page
from tests.website.conftest import open_site


@pytest.mark.slow("a browser on a busy machine")
def test_words_that_fit_can_be_tapped_and_taken_back(address: str, browser: Browser, keep: Keep) -> None:
    tablet = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    page, wrong = new_page(tablet)
    open_site(page, address)
    text, row, offered = (
        page.locator("#text"),
        page.get_by_role("group", name="Words to tap"),
        page.locator("#word-completions"),
    )
    text.fill("hill = forward left\nada $ ")
    text.press_sequentially("h")
    hill = offered.get_by_role("button", name="hill", exact=True)
    expect(hill).to_be_in_viewport()
    expect(page.locator("#completions")).to_be_hidden()  # it would cover the text
    place = hill.bounding_box()
    expect(page.locator("#diagnostics")).to_be_visible()  # after a moment, in which somebody may be about to tap
    assert hill.bounding_box() == place
    keep(page, "word-row.png")
    # By the mouse: if the machine is busy between the touch and its end, the browser takes a tap for a long press.
    hill.hover()
    page.mouse.down()
    page.keyboard.type("i")
    expect(text).to_have_value("hill = forward left\nada $ hi")
    expect(offered.get_by_role("button")).to_have_count(3)  # nothing moves while something is pressed
    page.mouse.up()
    expect(text).to_have_value("hill = forward left\nada $ hill")
    expect(text).to_be_focused()
    row.get_by_role("button", name="repeat", exact=True).click()
    expect(text).to_have_value("hill = forward left\nada $ hill repeat ")
    row.get_by_role("button", name="(", exact=True).click()
    expect(hill).to_be_visible()  # before a letter is typed
    expect(offered.get_by_role("button", name="forward", exact=True)).to_have_count(0)  # it is always there
    page.set_viewport_size({"width": 390, "height": 504})  # the keyboard is open
    text.fill("ada $ right 360 ")
    fix, undo = page.get_by_role("button", name=re.compile("Fix: .*360deg")), row.get_by_role("button", name="Undo")
    expect(fix).to_be_in_viewport(ratio=1)
    expect(undo).to_be_in_viewport(ratio=1)
    text.press("Backspace")
    text.press("ArrowLeft")
    text.click()  # behind the number
    offered.get_by_role("button", name="deg", exact=True).click()
    text.press("Space")
    expect(offered.get_by_role("button").first).to_have_text("radius")
    undo.click()
    undo.click()
    expect(text).to_have_value("ada $ right 360")
    expect(text).to_be_focused()
    text.blur()
    undo.click()
    expect(text).to_have_value("ada $ right 360 ")
    expect(text).not_to_be_focused()
    tablet.close()
    assert wrong == []
