"""The page with many robots: their names, rings, rows, and lists leave room for each other and for the floor."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.page.conftest import Keep, wait

SIZES = ((1280, 800), (1920, 1080), (390, 844))
NAMES = [f"a_robot_with_a_long_name_{number:02}" for number in range(1, 31)]
PROGRAM = f"{' '.join(NAMES)} $ until cue repeat pause near (forward left)\n"
CIRCLE = '[formation]\nshape = "circle"\ndistance = 2\n'
# Number of cut pixels in the last visible row.
CUT = """() => {
  const { bottom } = document.getElementById("tracks").getBoundingClientRect()
  const rows = [...document.querySelectorAll("#cast-list li")].map((row) => row.getBoundingClientRect())
  const last = rows.findLast(({ top }) => top < bottom - 1)
  return last.bottom - bottom
}"""
# True if the floor has this place in view, and nothing lies on it.
FREE = """({ x, y }) => {
  const place = improv.toScreen(x, y)
  const stage = document.getElementById("stage")
  const { left, top } = stage.getBoundingClientRect()
  return document.elementFromPoint(left + place.x, top + place.y) === stage
}"""
RESTS = "(v => (window.last === JSON.stringify(v) || (window.last = JSON.stringify(v), 0)))(improv.view)"


def whole_rows(page: Page, number: int) -> None:
    """Check that there are `number` rows, and the last visible one is whole."""
    expect(page.locator("#cast-list li")).to_have_count(number)
    wait(page, f"Math.abs(({CUT})()) < 1")


@pytest.mark.slow("looks at three sizes, three times each")
def test_thirty_robots_leave_room_for_the_floor(page: Page, still: Callable[..., Page], keep: Keep) -> None:
    still(PROGRAM, CIRCLE)
    expect(page.locator("#cast-head")).to_have_text("30 robots")
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        whole_rows(page, 30)
        for card in ("", "Help", "Starts"):
            press(page, card)
            wait(page, f"Object.values(improv.robots).length === 30 && Object.values(improv.robots).every({FREE})")
            box = page.locator("#hall").bounding_box()
            assert box
            assert box["height"] > 0.49 * height
            keep(page, f"page-thirty-{card or 'plain'}-{width}.png")
            if card:
                page.get_by_role("dialog").get_by_role("button", name="Close").click()


def press(page: Page, card: str) -> None:
    """Open a card by its button, also after unfolding it."""
    if not card:
        return
    button = page.get_by_role("button", name=card, exact=True)
    if not button.is_visible():
        page.get_by_role("button", name="View").click()
    button.click()


@pytest.mark.slow("waits until the camera rests")
def test_a_name_without_room_is_shown_to_those_who_point(page: Page, still: Callable[..., Page]) -> None:
    still(PROGRAM, '[formation]\nshape = "grid"\ndistance = 0.9\n')
    wait(page, f"{RESTS} && Object.keys(improv.robots).length === 30")
    shown = page.evaluate("improv.names")
    assert 0 < len(shown) < 30
    hidden = next(name for name in NAMES if name not in shown)
    page.locator(f"#cast-list li[data-robot={hidden}] .mute").focus()
    wait(page, f"improv.names.includes('{hidden}')")
    page.locator("#stage").focus()
    wait(page, f"!improv.names.includes('{hidden}')")
    box = page.locator("#stage").bounding_box()
    assert box
    place = page.evaluate(f"improv.toScreen(improv.robots.{hidden}.x, improv.robots.{hidden}.y)")
    page.mouse.move(box["x"] + place["x"], box["y"] + place["y"])
    wait(page, f"improv.names.includes('{hidden}')")


def test_eight_rows_end_with_a_whole_one_and_tools_make_way_for_a_card_on_a_phone(
    page: Page, still: Callable[..., Page]
) -> None:
    still("".join(f"r{number} $ repeat (forward left)\n" for number in range(8)))
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        whole_rows(page, 8)
    page.set_viewport_size({"width": 1280, "height": 800})
    press(page, "Starts")
    page.set_viewport_size({"width": 390, "height": 844})  # as when the window is made narrow
    dialog = page.get_by_role("dialog", name="Start poses")
    expect(dialog.get_by_role("button", name="Close")).to_be_in_viewport(ratio=1)
    for name in ("View", "Fit", "Zoom in"):
        expect(page.get_by_role("button", name=name)).to_be_hidden()
    dialog.get_by_role("button", name="Close").click()
    for name in ("View", "Fit", "Zoom in"):
        expect(page.get_by_role("button", name=name)).to_be_in_viewport(ratio=1)
