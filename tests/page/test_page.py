"""The page in a real browser: its display and its requests."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, BrowserContext, Page, expect

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.page.server import PageServer
from improv_core.protocol.tickets import issue
from improv_core.score.motion import Pose, Twist
from improv_core.score.score import Score
from tests.page.conftest import LIMIT, Commands, Keep, link, part, transport, wait
from tests.web_server import served


def open_page(page: Page, viewer: PageServer) -> None:
    page.goto(link(viewer))
    wait(page, "window.improv?.connected")


@pytest.mark.slow("draws a dance, and is photographed twice")
def test_the_page_shows_a_dance_and_its_stop_button_stops_it(
    page: Page, viewer: PageServer, simulator: Simulator, commands: Commands, keep: Keep
) -> None:
    requested: list[str] = []
    page.on("request", lambda request: requested.append(request.url))
    open_page(page, viewer)
    expect(page.get_by_text("Save or play a program to see it dance")).to_be_visible()

    parts = {"ada": part("ada", Pose()), "bo": part("bo", Pose(9.0, 0.0, 0.0, 1.5))}
    simulator.prepare(Score(Fraction(60), parts), restart=True)
    viewer.publish(transport(1, "playing"))
    simulator.send("ada", Twist(x=1.5, yaw=0.5), 0.0)
    simulator.advance(2.5)
    ada = simulator.poses()["ada"]
    wait(page, f"Math.hypot(improv.robots.ada.x - {ada.x}, improv.robots.ada.y - {ada.y}) < 1e-3")
    expect(page.get_by_text("Save or play a program to see it dance")).to_be_hidden()
    expect(page.locator("#state")).to_have_text("playing")
    expect(page.locator("#about")).to_have_text("60 beats/min simulator")
    expect(page.get_by_role("status")).to_have_text("playing 8 beats at 60 beats per minute")
    viewer.publish(transport(1, "paused", beat=2.5))
    expect(page.locator("#beat")).to_have_text("beat 3 / 8")
    expect(page.get_by_role("img")).to_have_accessible_name("The stage, seen from above, with ada, bo")
    keep(page, "page.png")

    assert commands.get(timeout=LIMIT) == {"type": "page_opened"}
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
    viewer.publish(transport(1, "playing"))
    expect(page.locator("#state")).to_have_text("playing")
    viewer.publish({"type": "stopped"})  # the performance is over: a page without the simulator hears no more of robots
    expect(page.locator("#state")).to_have_text("stopped")
    assert {urlsplit(url).netloc for url in requested} == {urlsplit(viewer.address).netloc}


@pytest.mark.slow("opens pages in two windows")
def test_a_page_can_be_opened_again_in_its_browser_and_its_address_opens_nothing_for_others(
    browser: Browser, window: BrowserContext, viewer: PageServer
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
    other.goto(viewer.address)
    expect(other.locator("#notice")).to_contain_text("This address works only once", timeout=LIMIT * 1000)
    assert not other.evaluate("improv.connected")
    other.close()

    viewer.close()  # its token is worth nothing for the next server
    port = urlsplit(viewer.address).port or 0
    next_server = PageServer(port, Simulator().snapshot, lambda command: None, token="another token")
    expect(again.locator("#notice")).to_contain_text("Improv was started again", timeout=LIMIT * 1000)
    assert not again.evaluate("improv.connected")
    other = window.new_page()
    with again.expect_event("load"):  # it takes the token that this browser was given
        other.goto(f"{viewer.address}?ticket={issue('another token')}")
    wait(again, "window.improv?.connected")
    for each in (again, other):
        each.close()
    next_server.close()


@pytest.mark.slow("opens pages in frames")
def test_a_frame_has_a_token_only_if_its_own_address_has_a_ticket(
    window: BrowserContext, viewer: PageServer, tmp_path: Path
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
