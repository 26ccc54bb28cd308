"""Words to tap above the keyboard of a tablet."""

from __future__ import annotations

import pytest
from playwright.sync_api import Browser, expect

from tests.page.conftest import Keep, new_page
from tests.website.conftest import open_site


@pytest.mark.slow("a browser on a busy machine")
def test_words_that_fit_can_be_tapped(address: str, browser: Browser, keep: Keep) -> None:
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
    tablet.close()
    assert wrong == []
