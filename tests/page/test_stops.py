"""*Stop* on the page in a real browser, while the process that should get it hangs or is gone."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from improv_core.outputs.simulator.simulator import Simulator
from improv_core.page import routes
from improv_core.page.server import PageServer
from tests.page.conftest import LIMIT, TOKEN, Commands, Keep, Show, leave, link, new_page, wait, watch
from tests.processes import halt
from tests.safety.stages import Stages

NOTICE = "Stop is not confirmed yet. Trying again…"


@pytest.fixture
def show() -> Iterator[Show]:
    """Here the stage is a process of its own."""
    show = Show()
    yield show
    show.close()


@pytest.mark.slow("waits until a process that hangs is killed")
def test_a_stop_arrives_after_all_when_the_stage_was_frozen_and_killed(page: Page, show: Show, keep: Keep) -> None:
    watch(page, show, "ada $ repeat forward\n")
    page.keyboard.press("Space")
    expect(page.locator("#state")).to_have_text("stopped")
    expect(page.locator("#notice")).to_be_hidden()
    assert show.stops >= 1  # one that came late is repeated, and counts again; until then, nothing plays
    while not show.play("ada $ repeat forward\n"):
        pass
    before = show.stops
    expect(page.locator("#state")).to_have_text("playing")
    halt(show.stage)
    page.get_by_role("button", name="Stop").click()
    expect(page.locator("#notice")).to_have_text(NOTICE)
    keep(page, "page-stop-unconfirmed.png")
    # The parent kills the stage, and starts another.
    expect(page.locator("#notice")).to_be_hidden()
    assert show.stops > before


@pytest.mark.slow("waits until the page tries again")
def test_a_stop_is_sent_again_until_there_is_a_server_and_it_is_confirmed(page: Page, viewer: PageServer) -> None:
    page.goto(link(viewer))
    wait(page, "window.improv?.connected")
    viewer.close()
    expect(page.locator("#notice")).to_have_text("Disconnected. Trying again…")
    page.get_by_role("button", name="Stop").click()
    expect(page.locator("#notice")).to_have_text(NOTICE)
    commands: Commands = queue.SimpleQueue()
    again = PageServer(urlsplit(viewer.address).port or 0, Simulator().snapshot, commands.put, token=TOKEN)
    while (command := commands.get(timeout=LIMIT))["type"] != "stop":
        pass
    expect(page.locator("#notice")).to_have_text(NOTICE)
    again.publish({"type": "obeyed", "direct": command["direct"]})
    expect(page.locator("#notice")).to_be_hidden()
    again.publish({"type": "stopped"})
    again.close()
    expect(page.locator("#notice")).to_contain_text("The performance is over")


def test_the_page_names_the_robots_yet_to_obey_a_stop(
    page: Page, commands: Commands, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(routes, "ASK_LIMIT", 0.05)
    monkeypatch.setattr(routes, "CONFIRM_LIMIT", 0.5)
    with TemporaryDirectory(dir="/tmp") as folder:
        stages = Stages(Path(folder, "7-abc"), "ros", hangs="ros")
        viewer = PageServer(0, Simulator().snapshot, commands.put, token=TOKEN, show=Path(folder, "7-abc"))
        page.goto(link(viewer))
        wait(page, "window.improv?.connected")
        page.get_by_role("button", name="Stop").click()
        line = "Stop is not confirmed yet by the real robots. Trying again…"
        expect(page.locator("#notice")).to_have_text(line)
        expect(page.locator("#news")).to_have_text(line)
        stages.hangs = ""
        expect(page.locator("#notice")).to_be_hidden()
        viewer.close()
        stages.close()


def test_a_stop_arrives_even_if_its_page_is_closed_at_once(page: Page, viewer: PageServer, commands: Commands) -> None:
    page.goto(link(viewer))
    wait(page, "window.improv?.connected")
    page.evaluate("""() => {
      WebSocket.prototype.send = () => {}  // as if it were full
      document.querySelector("#stop").click()
      location.href = "about:blank"
    }""")
    while commands.get(timeout=LIMIT)["type"] != "stop":
        pass


def test_a_stop_arrives_even_if_the_page_can_draw_nothing(
    window: BrowserContext, viewer: PageServer, commands: Commands
) -> None:
    page, wrong = new_page(window)
    page.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page.goto(link(viewer))
    page.get_by_role("button", name="Stop").click()
    while commands.get(timeout=LIMIT)["type"] != "stop":
        pass
    assert "this browser can't draw" in wrong[0]
    leave(page)
