"""The page seen from the back row: the stage alone, names where phrases begin, and formations to choose."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Page, expect

from tests.stage.viewer.conftest import Show, wait, watch

DANCE = "beat 60\nsquare = repeat 4 (forward left)\nverse = square square forward\nada $ verse verse\n"
NAME = "the_robot_with_the_longest_name"


def test_present_shows_the_stage_and_the_beat_alone(page: Page, show: Show, artifacts: Path) -> None:
    show.play(f"beat 60\nada {NAME} $ repeat forward\n")
    watch(page, show)
    page.set_viewport_size({"width": 1920, "height": 1080})
    beat = page.locator("#beat-now")
    small = beat.bounding_box()
    page.keyboard.press("p")
    for hidden in ("#timeline", "#score", "#tools", "#controls", "#caption"):
        expect(page.locator(hidden)).to_be_hidden()
    wait(page, "document.getElementById('stage').clientHeight === innerHeight")
    large = beat.bounding_box()
    assert small
    assert large
    assert large["height"] > 5 * small["height"]
    wait(page, f"improv.robots.ada && improv.toScreen(improv.robots.ada.x, 0).x > {large['x'] + large['width']}")
    page.screenshot(path=artifacts / "page-present.png")
    page.keyboard.press("p")
    expect(page.locator("#timeline")).to_be_visible()
    page.keyboard.press("p")
    page.keyboard.press("Escape")  # stops, as everywhere
    expect(page.locator("#state")).to_have_text("stopped")
    page.get_by_role("button", name="Present").click()
    expect(page.locator("#score")).to_be_visible()


def test_names_stand_where_phrases_begin(page: Page, show: Show) -> None:
    show.play(DANCE)
    watch(page, show)
    found = page.evaluate(
        """async ([text]) => {
          const { labels, Reader } = await import("/items.js")
          const words = { forward: [1, 0, 0, 0], left: [0, 0, 0, 1] }
          const at = (word, from = 0) => [text.indexOf(word, from), text.indexOf(word, from) + word.length]
          const [one, other] = [at("verse", text.indexOf("$")), at("verse", text.lastIndexOf("verse"))]
          const [first, second] = [at("square", text.indexOf("verse")), at("square", text.lastIndexOf("square"))]
          const square = (names) => [0, 1, 2, 3].flatMap(() => [[...names, at("forward")], [...names, at("left")]])
          const end = at("forward", second[1])
          const verse = (name) => [...square([name, first]), ...square([name, second]), [name, end]]
          const velocity = { x: 1, y: 0, z: 0, yaw: 0 }
          const stretches = [...verse(one), ...verse(other)].map((words, start) => ({ start, velocity, words }))
          const reader = new Reader(text, words)
          const show = (from) => labels(stretches, from, 34, reader).map(({ start, text }) => `${start} ${text}`)
          return [show(0), show(12)]
        }""",
        [DANCE],
    )
    whole = ["0 verse › square", "8 square", "17 verse › square", "25 square"]
    assert found == [whole, whole]  # wherever the view begins


def test_the_score_scrolls_to_the_word_that_plays(page: Page, show: Show) -> None:
    show.play("#\n" * 80 + "step = forward\n" + "#\n" * 80 + "ada $ repeat step\n")
    watch(page, show)
    expect(page.locator("#score-text .moving.lit")).to_be_in_viewport()


def test_long_names_fit_and_letters_are_explained(page: Page, show: Show) -> None:
    show.play(f"beat 60\nada {NAME} $ repeat forward\n")
    watch(page, show)
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
    page.locator("#dynamics").hover()  # nothing is in the way of the pointer
    expect(page.locator("li[data-robot=ada] .mute")).to_have_attribute(
        "title", "Mute: ada stands still while the others play"
    )
    page.keyboard.press("?")
    for word in ("Score", "M", "S", "ideal motion"):
        expect(page.locator("#help dt").get_by_text(word, exact=True).first).to_be_visible()


def test_a_formation_is_offered_and_not_written_unasked(page: Page, show: Show, artifacts: Path) -> None:
    show.play("ada $ rest\nbo $ rest\n")
    watch(page, show)
    page.evaluate("void (WebSocket.prototype.send = (text) => (window.sent ??= []).push(JSON.parse(text)))")
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
    page.screenshot(path=artifacts / "page-formation.png")
    assert page.evaluate("(window.sent ?? []).filter(({ type }) => type === 'form')") == []
    page.locator("#formation-offer-write").click()
    assert page.evaluate("sent.filter(({ type }) => type === 'form')") == [
        {"type": "form", "shape": "line", "distance": 1.25, "facing": "in"}
    ]
