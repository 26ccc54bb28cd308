"""The page in a real browser: its display and its requests."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.page.server import Viewer
from improv_core.score.motion import Pose, Twist
from improv_core.score.score import Score
from tests.page.conftest import LIMIT, TOKEN, Commands, Keep, link, next_frame, part, transport, wait
from tests.web_server import served


def open_page(page: Page, viewer: Viewer) -> None:
    page.goto(link(viewer))
    wait(page, "window.improv?.connected")


@pytest.mark.slow("draws a dance, and is photographed twice")
def test_the_page_shows_a_dance_and_its_stop_button_stops_it(
    page: Page, viewer: Viewer, simulator: Simulator, commands: Commands, keep: Keep
) -> None:
    requested: list[str] = []
    page.on("request", lambda request: requested.append(request.url))
    open_page(page, viewer)
    expect(page.get_by_text("Save a program to see it dance")).to_be_visible()

    cast = {"ada": Pose(), "bo": Pose(9.0, 0.0, 0.0, 1.5), "cleo": Pose(9.0, 9.0, 0.0, 3.0), "dot": Pose(0.0, 9.0)}
    simulator.prepare(Score(Fraction(60), {robot: part(robot, start) for robot, start in cast.items()}), restart=True)
    viewer.publish(transport(1, "playing"))
    for index, robot in enumerate(cast):
        for beat in range(8):
            simulator.send(robot, Twist(x=1.5, yaw=math.sin(beat * 1.7 + index) * 2.5), float(beat))
    for half in range(1, 6):
        simulator.advance(half / 2)
        next_frame(page)
    ada = simulator.poses()["ada"]
    wait(page, f"Math.hypot(improv.robots.ada.x - {ada.x}, improv.robots.ada.y - {ada.y}) < 1e-3")
    expect(page.get_by_text("Save a program to see it dance")).to_be_hidden()
    expect(page.locator("#state")).to_have_text("playing")
    expect(page.locator("#about")).to_have_text("60 beats/min simulator")
    expect(page.get_by_role("status")).to_have_text("playing 8 beats at 60 beats per minute")
    viewer.publish(transport(1, "paused", beat=2.5))
    expect(page.locator("#beat")).to_have_text("beat 3 / 8")
    expect(page.get_by_role("img")).to_have_accessible_name("The stage, seen from above, with ada, bo, cleo, dot")
    keep(page, "page-light.png")
    page.emulate_media(color_scheme="dark")
    page.set_viewport_size({"width": 390, "height": 844})
    next_frame(page)
    next_frame(page)
    keep(page, "page-dark-phone.png")

    assert commands.get(timeout=LIMIT) == {"type": "watched"}
    stop = page.get_by_role("button", name="Stop")
    stops: list[Callable[[], None]] = [
        stop.click,
        lambda: page.keyboard.press("Space"),  # while the button has the focus: once, not twice
        lambda: page.keyboard.press("Escape"),
    ]
    for press in stops:
        press()
        assert commands.get(timeout=LIMIT)["type"] == "stop"
    viewer.publish(transport(1, "stopped", beat=2.5))
    expect(page.locator("#state")).to_have_text("stopped")
    assert commands.empty()
    assert {urlsplit(url).netloc for url in requested} == {urlsplit(viewer.address).netloc}


@pytest.mark.slow("a browser on a busy machine")
def test_the_page_counts_the_beat_itself(page: Page, viewer: Viewer) -> None:
    open_page(page, viewer)
    viewer.publish(transport(1, "playing", beats=None))
    wait(page, "/^beat ([3-9]|[1-9][0-9]+) · ∞$/.test(document.querySelector('#beat').textContent)")
    viewer.publish(transport(1, "ended", beats=7.5, beat=7.5))
    expect(page.locator("#beat")).to_have_text("beat 8 / 8")
    expect(page.locator("#state")).to_have_text("ended")


def test_the_page_shows_the_right_beat_even_if_it_learns_the_time_late(page: Page, viewer: Viewer) -> None:
    page.add_init_script(
        """const parse = JSON.parse
        JSON.parse = (text) => {
          const message = parse(text)
          return message?.type === "time" ? { ...message, wall: message.wall - 5 } : message
        }"""
    )
    open_page(page, viewer)
    viewer.publish(transport(1, "playing", beats=None, beat=10.0))
    wait(page, "improv.transport.state === 'playing'")
    wait(page, "Math.abs(10 + Date.now() / 1000 - improv.transport.wall - improv.beat) < 0.1")


def test_a_new_program_starts_with_a_clean_stage(page: Page, viewer: Viewer, simulator: Simulator) -> None:
    open_page(page, viewer)
    simulator.prepare(Score(Fraction(60), {"ada": part("ada", Pose()), "bo": part("bo", Pose(0.0, 2.0))}), restart=True)
    wait(page, "Object.keys(improv.robots).join() == 'ada,bo'")
    simulator.send("ada", Twist(x=1.0), 0.0)
    simulator.advance(3.0)
    wait(page, "improv.robots.ada.x == 3")
    simulator.prepare(Score(Fraction(60), {"ada": part("ada", Pose(1.0, 1.0))}), restart=True)
    wait(page, "Object.keys(improv.robots).join() == 'ada' && improv.robots.ada.y == 1")


def test_starts_are_only_copied_if_no_program_gets_them(page: Page, viewer: Viewer) -> None:
    viewer.show(Score(Fraction(60), {"ada": part("ada", Pose())}), 1)
    viewer.publish(transport(1, "stopped"))
    open_page(page, viewer)
    page.get_by_role("button", name="Starts").click()
    page.get_by_label("x", exact=True).fill("1")
    expect(page.get_by_role("button", name="Copy")).to_be_visible()
    expect(page.locator("#start-poses-offer-lines")).to_contain_text("start = { x = 1, y = 0, heading = 0 }")


def test_the_page_comes_back_after_the_server(page: Page, viewer: Viewer, simulator: Simulator) -> None:
    open_page(page, viewer)
    where = urlsplit(viewer.address)
    viewer.close()
    notice = page.locator("#notice")
    expect(notice).to_have_text("Disconnected. Trying again…")
    expect(page.get_by_role("status")).to_have_text("Disconnected. Trying again…")
    expect(page.get_by_role("button", name="Stop")).to_have_attribute("aria-disabled", "false")
    expect(page.get_by_role("button", name="Play", exact=True)).to_have_attribute("aria-disabled", "true")
    assert page.evaluate("improv.connected") is False

    assert where.port
    again = Viewer(where.port, simulator.snapshot, lambda command: None, token=TOKEN)
    again.publish(transport(4, "stopped"))
    expect(page.locator("#state")).to_have_text("stopped")
    expect(notice).to_be_hidden()
    expect(page.get_by_role("status")).to_have_text("stopped")
    again.close()
    expect(notice).to_be_visible()


@pytest.mark.slow("opens pages in two windows")
def test_a_page_can_be_opened_again_in_its_browser_and_its_address_opens_nothing_for_others(
    browser: Browser, window: BrowserContext, viewer: Viewer
) -> None:
    url, page = link(viewer), window.new_page()
    page.goto(url)
    wait(page, "window.improv?.connected")
    assert page.url == viewer.address
    page.close()
    again = window.new_page()  # as a closed tab that is opened again
    again.goto(viewer.address)
    wait(again, "window.improv?.connected")
    other = browser.new_page()
    for address in (viewer.address, url):
        other.goto(address)
        expect(other.locator("#notice")).to_contain_text("This address works only once", timeout=LIMIT * 1000)
        assert not other.evaluate("improv.connected")
    other.close()

    viewer.close()  # its token is worth nothing for the next server
    next_server = Viewer(urlsplit(viewer.address).port or 0, Simulator().snapshot, lambda command: None)
    expect(again.locator("#notice")).to_contain_text("This address works only once", timeout=LIMIT * 1000)
    again.close()
    next_server.close()


@pytest.mark.slow("opens pages in frames")
def test_a_frame_has_a_token_only_if_its_own_address_has_a_ticket(
    window: BrowserContext, viewer: Viewer, tmp_path: Path
) -> None:
    """Any user of this machine can serve a page that frames ours in a tab that has its token."""
    page = window.new_page()
    open_page(page, viewer)
    for name, address in {"index.html": viewer.address, "again.html": link(viewer)}.items():
        (tmp_path / name).write_text(f"<iframe src='{address}'></iframe>", encoding="utf-8")
    with served(tmp_path) as stranger:
        page.goto(stranger)
        notice = page.frame_locator("iframe").locator("#notice")
        expect(notice).to_contain_text("This address works only once", timeout=LIMIT * 1000)
        page.goto(f"{stranger}again.html")  # as VS Code's panel, which has a ticket
        expect(page.frame_locator("iframe").locator("#state-word")).to_have_text("ready", timeout=LIMIT * 1000)
    page.close()
