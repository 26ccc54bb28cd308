"""The page seen from the back row: the stage alone, names where phrases begin, and formations to choose."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.page.conftest import Keep, Show, wait, watch

LETTERS = "text => parseFloat(getComputedStyle(text).fontSize)"
NAME = "the_robot_with_the_longest_name"


@pytest.mark.slow("draws full screen")
def test_present_shows_the_stage_the_program_and_the_beat(page: Page, show: Show, keep: Keep) -> None:
    watch(page, show, f"beat 60\nada {NAME} $ repeat forward\n")
    page.set_viewport_size({"width": 1920, "height": 1080})
    beat, program = page.locator("#beat-now"), page.locator("#score-text")
    small, letters = beat.bounding_box(), program.evaluate(LETTERS)
    page.get_by_role("button", name="Present").click()
    for hidden in ("#timeline", "#tools", "#controls", "#caption"):
        expect(page.locator(hidden)).to_be_hidden()
    wait(page, "document.getElementById('stage').clientHeight === innerHeight")
    large = beat.bounding_box()
    assert small
    assert large
    assert large["height"] > 5 * small["height"]
    assert program.evaluate(LETTERS) > 1.3 * letters
    expect(program.locator(".moving.lit")).to_have_text(["forward"])
    wait(page, f"improv.robots.ada && improv.toScreen(improv.robots.ada.x, 0).y > {large['y'] + large['height']}")
    keep(page, "page-present.png")

    for part, key in (("Program", "s"), ("Beat", "b")):  # the page names the key
        button = page.get_by_role("button", name=f"{part} {key.upper()}")
        shown = program if part == "Program" else beat
        page.keyboard.press(key)
        expect(shown).to_be_hidden()
        expect(button).to_have_attribute("aria-pressed", "false")
        button.click()
        expect(shown).to_be_visible()
    for key in "lt?":  # of panels that are hidden
        page.keyboard.press(key)
    page.keyboard.press("Escape")  # stops, as everywhere
    expect(page.locator("#state")).to_have_text("stopped")
    page.keyboard.press("p")
    expect(page.locator("#timeline")).to_be_visible()
    expect(page.get_by_role("dialog", name="Help")).to_be_hidden()
    expect(page.get_by_label("Trails")).to_have_value("Infinity")


def test_on_a_phone_presented_robots_are_not_below_stop(still: Callable[..., Page], keep: Keep) -> None:
    page = still(f"{' '.join(f'r{number}' for number in range(12))} $ repeat rest\n")
    page.set_viewport_size({"width": 390, "height": 844})
    page.get_by_role("button", name="Present").click()
    stop = page.locator("#stop").bounding_box()
    assert stop
    wait(page, f"improv.robots.r0 && improv.toScreen(0, 0).y > {stop['y'] + stop['height']}")
    keep(page, "page-present-small.png")


def test_long_names_fit_letters_are_explained_and_the_score_scrolls_to_the_word_that_plays(
    still: Callable[..., Page],
) -> None:
    page = still("#\n" * 80 + "step = forward\n" + "#\n" * 80 + f"ada {NAME} $ repeat step\n")
    expect(page.locator("#score-text .moving.lit")).to_be_in_viewport()
    for width in (390, 1280):
        page.set_viewport_size({"width": width, "height": 844})
        name = page.locator(f"li[data-robot={NAME}] .name")
        if not name.is_visible():
            page.keyboard.press("l")
        expect(name).to_be_visible()
        assert name.evaluate(
            "name => name.scrollHeight <= name.clientHeight + 1 && name.scrollWidth <= name.clientWidth"
        )
    expect(page.locator("label[for=trail]")).to_be_visible()
    expect(page.locator("#dynamics")).to_have_attribute(
        "title", "Simulated robots change speed at once and are exactly where the program puts them. Real ones are not."
    )
    page.locator("#dynamics").hover()  # nothing covers the pointer
    expect(page.locator("li[data-robot=ada] .mute")).to_have_attribute(
        "title", "Mute: ada stands still while the others play"
    )
    page.keyboard.press("?")
    for word in ("Score", "M", "S", "ideal motion"):
        expect(page.locator("#help dt").get_by_text(word, exact=True).first).to_be_visible()


def test_a_formation_is_offered_as_lines_if_no_program_gets_it(still: Callable[..., Page], keep: Keep) -> None:
    page = still("ada $ rest\nbo $ rest\n")
    page.get_by_role("button", name="Starts").click()
    page.get_by_text("Formation", exact=True).click()
    lines = page.locator("#formation-offer-lines")
    page.get_by_role("button", name="Circle, out").click()
    expect(lines).to_have_text('[formation]\nshape = "circle"\ndistance = 3\nfacing = "out"')
    distance = page.get_by_label("Distance in meters")
    distance.fill("0.1")  # they would overlap
    expect(lines).to_be_hidden()
    distance.fill("1.25")
    page.get_by_role("button", name="Line", exact=True).click()
    expect(lines).to_have_text('[formation]\nshape = "line"\ndistance = 1.25')
    keep(page, "page-formation.png")


def test_a_formation_is_sent_to_an_editor(page: Page, show: Show) -> None:
    watch(page, show, "ada $ rest\nbo $ rest\n")
    page.evaluate("void (WebSocket.prototype.send = (text) => (window.sent ??= []).push(JSON.parse(text)))")
    page.get_by_role("button", name="Starts").click()
    page.get_by_text("Formation", exact=True).click()
    distance = page.get_by_label("Distance in meters")
    distance.fill("0.1")  # they would overlap
    page.get_by_role("button", name="Line", exact=True).click()
    distance.fill("1.25")
    assert page.evaluate("(window.sent ?? []).filter(({ type }) => type === 'form')") == []
    distance.press("Enter")
    assert page.evaluate("sent.filter(({ type }) => type === 'form')") == [
        {"type": "form", "shape": "line", "distance": 1.25, "facing": "in"}
    ]
    expect(page.locator("#formation-offer-lines")).to_be_hidden()
