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


def whole_rows(page: Page, number: int) -> None:
    """Check that there are `number` rows, and the last visible one is whole."""
    expect(page.locator("#cast-list li")).to_have_count(number)
    wait(page, f"Math.abs(({CUT})()) < 1")


@pytest.mark.slow("looks at three sizes, twice each")
def test_thirty_robots_leave_room_for_the_floor(page: Page, still: Callable[..., Page], keep: Keep) -> None:
    still(PROGRAM, CIRCLE)
    expect(page.locator("#cast-head")).to_have_text("30 robots")
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        whole_rows(page, 30)
        for card in ("plain", "Starts"):
            button = page.get_by_role("button", name=card, exact=True)
            if card == "Starts":
                if not button.is_visible():
                    page.get_by_role("button", name="View").click()
                button.click()
            wait(page, f"Object.values(improv.robots).length === 30 && Object.values(improv.robots).every({FREE})")
            box = page.locator("#hall").bounding_box()
            assert box
            assert box["height"] > 0.49 * height
            keep(page, f"page-thirty-{card}-{width}.png")
        page.get_by_role("dialog").get_by_role("button", name="Close").click()
