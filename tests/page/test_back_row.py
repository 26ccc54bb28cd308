"""The page seen from the back row, the stage alone, and formations to choose."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.page.conftest import Keep, Show, box, wait, watch

LETTERS = "text => parseFloat(getComputedStyle(text).fontSize)"


@pytest.mark.slow("draws full screen")
def test_present_shows_the_stage_the_program_and_the_beat(page: Page, show: Show, keep: Keep) -> None:
    watch(page, show, "beat 60\nada $ repeat forward\n")
    page.set_viewport_size({"width": 1920, "height": 1080})
    beat, program = page.locator("#beat-now"), page.locator("#score-text")
    small, letters = box(page, "#beat-now"), program.evaluate(LETTERS)
    page.get_by_role("button", name="Present").click()
    for hidden in ("#timeline", "#tools", "#controls", "#caption"):
        expect(page.locator(hidden)).to_be_hidden()
    wait(page, "document.getElementById('stage').clientHeight === innerHeight")
    large = box(page, "#beat-now")
    assert large["height"] > 5 * small["height"]
    assert program.evaluate(LETTERS) > 1.3 * letters
    expect(program.locator(".moving.lit")).to_have_text(["forward"])
    wait(page, f"improv.robots.ada && improv.toScreen(improv.robots.ada.x, 0).y > {large['y'] + large['height']}")
    keep(page, "page-present.png")

    for name, key, shown in (("Program S", "s", program), ("Beat B", "b", beat)):
        page.keyboard.press(key)
        expect(shown).to_be_hidden()
        page.get_by_role("button", name=name).click()
        expect(shown).to_be_visible()
    page.keyboard.press("Escape")  # stops, as everywhere
    expect(page.locator("#state")).to_have_text("stopped")
    page.keyboard.press("p")
    expect(page.locator("#timeline")).to_be_visible()


def test_a_formation_is_offered_as_lines_if_no_program_gets_it(still: Callable[..., Page], keep: Keep) -> None:
    page = still("ada $ rest\nbo $ rest\n")
    page.get_by_role("button", name="Starts").click()
    page.get_by_text("Formation", exact=True).click()
    lines = page.locator("#formation-toml-lines")
    page.get_by_role("button", name="Circle, out").click()
    expect(lines).to_have_text('[formation]\nshape = "circle"\ndistance = 3\nfacing = "out"')
    distance = page.get_by_label("Distance in meters")
    distance.fill("0.1")  # they would overlap
    expect(lines).to_be_hidden()
    distance.fill("1.25")
    page.get_by_role("button", name="Line", exact=True).click()
    expect(lines).to_have_text('[formation]\nshape = "line"\ndistance = 1.25')
    keep(page, "page-formation.png")
