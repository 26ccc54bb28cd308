"""A real browser, and how to wait for what a page shows."""

from __future__ import annotations

import os
import queue
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, sync_playwright

from improv_core.motion import Pose
from improv_core.movement import series
from improv_core.profiles import Profile
from improv_core.score import Part
from improv_core.stage.sinks.simulator import Simulator
from improv_core.stage.viewer.server import Viewer
from tests.needs import need

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
LIMIT = 20.0


def part(robot: str, start: Pose) -> Part:
    return Part(robot, series([]), Profile("disc", step=2.0), start, f"/{robot}/cmd_vel")


@pytest.fixture
def commands() -> queue.SimpleQueue[dict[str, Any]]:
    return queue.SimpleQueue()


@pytest.fixture
def simulator() -> Simulator:
    return Simulator()


@pytest.fixture
def viewer(simulator: Simulator, commands: queue.SimpleQueue[dict[str, Any]]) -> Iterator[Viewer]:
    viewer = Viewer(0, simulator.snapshot, commands.put)
    yield viewer
    viewer.close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    chromium = need("chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """A page on which nothing may go wrong unnoticed."""
    wrong: list[str] = []

    def listen(message: ConsoleMessage) -> None:
        # A server that went away is an error to the browser, not to us.
        if message.type in ("error", "warning") and "net::ERR_CONNECTION" not in message.text:
            wrong.append(message.text)

    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.set_default_timeout(LIMIT * 1000)
    page.on("console", listen)
    page.on("pageerror", lambda error: wrong.append(str(error)))
    yield page
    page.close()
    assert wrong == []


@pytest.fixture
def artifacts() -> Path:
    folder = Path(os.environ.get("IMPROV_ARTIFACTS") or Path(__file__).parents[2] / ".artifacts")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def wait(page: Page, condition: str) -> None:
    """Look at every frame until the condition holds. (Playwright's own waiting needs eval, which the page forbids.)"""
    page.evaluate(
        f"""() => new Promise((done, fail) => {{
          const look = () => ({condition}) ? done() : requestAnimationFrame(look)
          setTimeout(() => fail(new Error("too late")), {LIMIT * 1000})
          look()
        }})"""
    )
