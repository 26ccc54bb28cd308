"""The page in a real browser: what it shows and what it sends."""

from __future__ import annotations

import math
import queue
import time
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, Page, expect

from improv_core.score.motion import Pose, Twist
from improv_core.score.score import Score
from improv_core.stage.protocol import PageRequest, Watched
from improv_core.stage.sinks.simulator import Simulator
from improv_core.stage.viewer.server import Viewer
from tests.stage.viewer.conftest import LIMIT, TOKEN, link, part, transport, wait


def open_page(page: Page, viewer: Viewer) -> None:
    page.goto(link(viewer))
    wait(page, "window.improv?.connected")


def next_frame(page: Page) -> None:
    page.evaluate("new Promise(requestAnimationFrame)")


def test_the_page_shows_a_dance_and_stop_sends_hush(
    page: Page,
    viewer: Viewer,
    simulator: Simulator,
    commands: queue.SimpleQueue[PageRequest | Watched],
    artifacts: Path,
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
    began = time.monotonic()
    while (performed := time.monotonic() - began) < 2.5:
        simulator.advance(performed)
        next_frame(page)
    ada = simulator.poses()["ada"]
    wait(page, f"Math.hypot(improv.robots.ada.x - {ada.x}, improv.robots.ada.y - {ada.y}) < 1e-3")
    expect(page.get_by_text("Save a program to see it dance")).to_be_hidden()
    expect(page.locator("#state")).to_have_text("playing")
    expect(page.locator("#beat")).to_have_text("beat 3 / 8")
    expect(page.locator("#about")).to_have_text("60 beats/min simulator")
    expect(page.get_by_role("status")).to_have_text("playing 8 beats at 60 beats per minute")
    expect(page.get_by_role("img")).to_have_accessible_name("The stage, seen from above, with ada, bo, cleo, dot")
    page.screenshot(path=artifacts / "page-light.png")
    page.emulate_media(color_scheme="dark")
    page.set_viewport_size({"width": 390, "height": 844})
    next_frame(page)
    next_frame(page)
    page.screenshot(path=artifacts / "page-dark-phone.png")

    assert commands.get(timeout=LIMIT) == {"type": "watched"}
    stop = page.get_by_role("button", name="Stop")
    stops: list[Callable[[], None]] = [
        stop.click,
        lambda: page.keyboard.press("Space"),  # while the button has the focus: once, not twice
        lambda: page.keyboard.press("Escape"),
    ]
    for press in stops:
        press()
        assert commands.get(timeout=LIMIT) == {"type": "hush"}
    viewer.publish(transport(1, "stopped", beat=2.5))
    expect(page.locator("#state")).to_have_text("stopped")
    assert commands.empty()
    assert {urlsplit(url).netloc for url in requested} == {urlsplit(viewer.address).netloc}


def test_the_beat_is_counted_by_the_page_itself(page: Page, viewer: Viewer) -> None:
    open_page(page, viewer)
    viewer.publish(transport(1, "playing", beats=None))
    for beat in range(1, 4):
        expect(page.locator("#beat")).to_have_text(f"beat {beat} · ∞")
    viewer.publish(transport(1, "ended", beats=7.5, beat=7.5))
    expect(page.locator("#beat")).to_have_text("beat 8 / 8")
    expect(page.locator("#state")).to_have_text("finished")


def test_the_motion_shown_is_smooth(page: Page, viewer: Viewer, simulator: Simulator) -> None:
    open_page(page, viewer)
    simulator.prepare(Score(Fraction(60), {"ada": part("ada", Pose())}), restart=True)
    simulator.send("ada", Twist(x=1.0), 0.0)
    page.evaluate(
        """() => {
          window.seen = []
          const look = () => { if (improv.robots.ada) seen.push(improv.robots.ada.x); requestAnimationFrame(look) }
          look()
        }"""
    )
    began = time.monotonic()
    while (performed := time.monotonic() - began) < 2.0:
        simulator.advance(performed)
        next_frame(page)
    seen: list[float] = page.evaluate("seen")
    assert seen == sorted(seen)
    assert len(set(seen)) > 20


def test_poses_are_drawn_between_two_messages(page: Page, viewer: Viewer) -> None:
    open_page(page, viewer)
    shown = page.evaluate(
        """async () => {
          const { Motion } = await import("/motion.js")
          const motion = new Motion()
          const poses = (i) => ({ ada: [i, 0, 2 * i, -i] })
          for (let i = 0; i <= 4; i++) motion.take({ at: i / 4, placed: 0, poses: poses(i) }, 100 + i / 4)
          const between = motion.present(100.925)
          const after = motion.present(102)
          const restarted = motion.take({ at: 0, placed: 1, poses: { ada: [7, 0, 0, 0] } }, 103)
          return { between, after, restarted, now: motion.present(103).robots.ada.x }
        }"""
    )
    assert shown["between"]["robots"]["ada"] == pytest.approx({"x": 3.5, "y": 0.0, "z": 7.0, "heading": -3.5})
    assert shown["between"]["moving"] is True
    assert shown["after"]["robots"]["ada"]["x"] == 4
    assert shown["after"]["moving"] is False
    assert shown["restarted"] is True
    assert shown["now"] == 7


def test_a_new_program_starts_with_a_clean_stage(page: Page, viewer: Viewer, simulator: Simulator) -> None:
    open_page(page, viewer)
    simulator.prepare(Score(Fraction(60), {"ada": part("ada", Pose()), "bo": part("bo", Pose(0.0, 2.0))}), restart=True)
    wait(page, "Object.keys(improv.robots).join() == 'ada,bo'")
    simulator.send("ada", Twist(x=1.0), 0.0)
    simulator.advance(3.0)
    wait(page, "improv.robots.ada.x == 3")
    simulator.prepare(Score(Fraction(60), {"ada": part("ada", Pose(1.0, 1.0))}), restart=True)
    wait(page, "Object.keys(improv.robots).join() == 'ada' && improv.robots.ada.y == 1")


def test_starts_are_only_copied_where_nobody_would_write_them(page: Page, viewer: Viewer) -> None:
    viewer.show(Score(Fraction(60), {"ada": part("ada", Pose())}), 1)
    viewer.publish(transport(1, "stopped"))
    open_page(page, viewer)
    page.get_by_role("button", name="Starts").click()
    page.get_by_label("x", exact=True).fill("1")
    expect(page.get_by_role("button", name="Copy")).to_be_visible()
    expect(page.get_by_role("button", name="Write to improv.toml")).to_be_hidden()


def test_the_page_comes_back_after_the_server(page: Page, viewer: Viewer, simulator: Simulator) -> None:
    open_page(page, viewer)
    where = urlsplit(viewer.address)
    viewer.close()
    notice = page.locator("#notice")
    expect(notice).to_have_text("Disconnected. Trying again…")
    expect(page.get_by_role("status")).to_have_text("Disconnected. Trying again…")
    expect(page.get_by_role("button", name="Stop")).to_have_attribute("aria-disabled", "true")
    assert page.evaluate("improv.connected") is False

    assert where.port
    again = Viewer(where.port, simulator.snapshot, lambda command: None, token=TOKEN)
    again.publish(transport(4, "stopped"))
    expect(page.locator("#state")).to_have_text("stopped")
    expect(notice).to_be_hidden()
    expect(page.get_by_role("status")).to_have_text("stopped")
    again.close()
    expect(notice).to_be_visible()


def test_a_page_of_an_earlier_token_is_told_so(browser: Browser, viewer: Viewer) -> None:
    page = browser.new_page()
    open_page(page, viewer)
    port = urlsplit(viewer.address).port
    assert port
    viewer.close()
    other = Viewer(port, Simulator().snapshot, lambda command: None)
    expect(page.locator("#notice")).to_contain_text("This link has expired", timeout=LIMIT * 1000)
    other.close()
    page.close()


def test_a_reloaded_page_goes_on_and_its_address_opens_nothing_for_others(
    browser: Browser, page: Page, viewer: Viewer
) -> None:
    url = link(viewer)
    page.goto(url)
    wait(page, "window.improv?.connected")
    assert page.url == viewer.address
    page.reload()
    wait(page, "window.improv?.connected")
    page.goto(url)  # as a frame does that is loaded again
    wait(page, "window.improv?.connected")
    other = browser.new_page()
    for address in (viewer.address, url):
        other.goto(address)
        expect(other.locator("#notice")).to_contain_text("This link has expired", timeout=LIMIT * 1000)
        assert not other.evaluate("improv.connected")
    other.close()
