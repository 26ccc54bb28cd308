"""The wall of robots: one line without a click, all robots by one click or key, and axe finds nothing."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from typing import Any

import pytest
from playwright.sync_api import Page, expect

from improv_core.protocol.page_messages import for_pages
from improv_core.protocol.robot_messages import FaultMessage, Vitals, VitalsRobot
from improv_core.score.faults import Fault
from tests.axe import Violations
from tests.page.conftest import SCHEMES, Keep, Show, box, play_anew, switch_to, wait

SIZES = ((1920, 1080), (1280, 800), (390, 844))
TROUBLE: Sequence[tuple[int, Fault]] = [(2, "silent"), (5, "off_path"), (5, "stuck"), (10, "gone")]


def robots(count: int) -> list[str]:
    return [f"tb{number}" for number in range(1, count + 1)]


def program(count: int) -> str:
    return f"beat 60\n{' '.join(robots(count))} $ repeat (forward left)\n"


def vitals(count: int, posed: float) -> Vitals:
    """List this many robots: every seventh has no odometry."""
    seen = {name: None if number % 7 == 6 else posed for number, name in enumerate(robots(count))}
    told: dict[str, VitalsRobot] = {
        name: {"odom": at is not None, "posed": at, "battery": 0.8, "instead": ""} for name, at in seen.items()
    }
    return {"type": "vitals", "generation": 1, "robots": told}


def faults(count: int) -> Iterator[FaultMessage]:
    for number, fault in TROUBLE:
        if number < count:
            yield {
                "type": "fault", "generation": 1, "robot": robots(count)[number], "fault": fault, "over": False,
                "response": "tell", "worst": {}, "message": f"beat 3: {robots(count)[number]} is in trouble",
                "line": f"beat 3: {robots(count)[number]} is in trouble",
                "beat": 2.0, "performed": 2.0, "wall": 0,
            }  # fmt: skip


PROGRAM = program(2)


def tell(show: Show, message: Any) -> None:
    """Send the page's stage this message, as from a stage of real robots that leads."""
    show.tell(for_pages(json.loads(json.dumps(message))))


@pytest.fixture
def show(shared: tuple[Show, Page]) -> Show:
    return shared[0]


@pytest.fixture
def page(shared: tuple[Show, Page]) -> Iterator[Page]:
    """The page, which has its usual size and looks, without a wall, after each test."""
    _, page = shared
    yield page
    page.emulate_media(color_scheme="light")
    page.set_viewport_size({"width": 1280, "height": 800})
    if page.locator("#wall").is_visible():
        page.get_by_role("dialog", name="Robots").get_by_role("button", name="Close").click()


def tell_faults(show: Show, count: int) -> None:
    """Report trouble of some of these robots."""
    for message in faults(count):
        tell(show, message)


def see(page: Page, show: Show, count: int, tempo: int = 60, posed: float = 1.0) -> None:
    """Begin this many robots, all well, each last seen at this second."""
    play_anew(page, show, program(count).replace("beat 60", f"beat {tempo}"))
    wait(page, "improv.transport.state === 'playing'")
    tell(show, vitals(count, posed))


def test_one_line_and_the_wall_that_a_key_opens_name_robots_in_trouble_first(page: Page, show: Show) -> None:
    see(page, show, 12)
    line = page.locator("#show-wall")
    expect(line).to_have_text("12 robots, all well")
    tell_faults(show, 12)
    expect(line).to_have_text("3 of 12 robots in trouble: tb11 gone; tb3 silent; tb6 stuck, off its path")
    expect(page.locator("#news")).to_have_text("beat 3: tb11 is in trouble")
    page.keyboard.press("w")
    rows = page.locator("#wall tbody tr")
    expect(rows.first).to_have_attribute("title", "beat 3: tb11 is in trouble")
    assert [rows.nth(place).locator("th").text_content() for place in range(4)] == ["tb11", "tb3", "tb6", "tb1"]
    tell(show, {**next(faults(12)), "over": True})
    expect(line).to_have_text("2 of 12 robots in trouble: tb11 gone; tb6 stuck, off its path")
    page.reload()  # a page that opens later knows the same
    expect(line).to_have_text("2 of 12 robots in trouble: tb11 gone; tb6 stuck, off its path")


def test_a_robot_that_is_lost_stays_where_it_was_last_seen(page: Page, show: Show) -> None:
    """With or without measured poses, it is not drawn as if it continued along its path."""
    see(page, show, 12, tempo=240, posed=-2.0)
    wait(page, "window.improv.beat > 1.2")
    where = "JSON.stringify([improv.drawn.tb3, improv.drawn.tb11])"
    tell_faults(show, 12)
    off = page.locator("li[data-robot=tb3] .off")
    expect(off).to_have_text(re.compile(r"^silent, last pose \d+ s ago$"))
    expect(page.locator("li[data-robot=tb11] .off")).to_have_text(re.compile(r"^gone, last pose \d+ s ago$"))
    wait(page, "JSON.stringify(improv.robots.tb3) !== JSON.stringify(improv.drawn.tb3)")
    seen, beat = page.evaluate(where), page.evaluate("improv.beat")
    wait(page, f"improv.beat > {beat + 0.7}")
    assert page.evaluate(where) == seen
    before = page.evaluate("JSON.stringify(improv.drawn.tb1)")
    wait(page, f"JSON.stringify(improv.drawn.tb1) !== {json.dumps(before)}")
    tell(show, {**next(faults(12)), "over": True})
    expect(off).to_have_text("")
    wait(page, "JSON.stringify(improv.robots.tb3) === JSON.stringify(improv.drawn.tb3)")


def test_the_page_says_why_robots_stand(page: Page, show: Show) -> None:
    see(page, show, 2)
    why, line = page.locator("#stands"), "Too near to each other: tb1, tb2. Make room, then press Play."
    expect(why).to_be_hidden()
    tell(show, {"type": "why_still", "line": line})
    expect(why).to_have_text(line)
    expect(page.locator("#news")).to_have_text(line)
    for width in (1280, 390):
        page.set_viewport_size({"width": width, "height": 844})
        expect(why).to_be_in_viewport(ratio=1)
    tell(show, {"type": "why_still", "line": ""})
    expect(why).to_be_hidden()


def test_buttons_resume_after_a_stop_that_nobody_asked_for(page: Page, show: Show) -> None:
    see(page, show, 2)
    resume = page.get_by_role("button", name="Resume from this")
    tell(show, {"type": "why_still", "line": "Robots were stopped.", "resumes": {"scene": 4000.0, "beat": 8000.5}})
    expect(resume).to_have_text(["Resume from this scene", "Resume from this beat"])
    for button, beat in ((resume.first, 4000), (resume.last, 8000.5)):
        button.click()
        wait(page, f"improv.beat >= {beat} && improv.beat < {beat + 1000}")
    tell(show, {"type": "why_still", "line": ""})
    expect(resume).to_have_count(0)


@pytest.mark.slow("axe looks at the page in three sizes and two colors")
def test_axe_finds_nothing_and_nothing_is_cut_off(violations: Violations, page: Page, show: Show, keep: Keep) -> None:
    see(page, show, 30)
    tell_faults(show, 30)
    page.locator("#show-wall").click()
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        for what in ("#show-wall", "#wall"):
            where = box(page, what)
            assert 0 <= where["x"] <= width - where["width"]
        assert page.locator("#stop").is_visible()
        for scheme in SCHEMES:
            switch_to(page, scheme)
            assert violations(page) == [], f"{width}, {scheme}"
            keep(page, f"wall-{width}-{scheme}.png")
