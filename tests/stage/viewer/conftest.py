"""A real browser, and how to wait for what a page shows."""

from __future__ import annotations

import asyncio
import os
import queue
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, sync_playwright

from improv_core.playback.playback import Playback
from improv_core.playback.start import Options
from improv_core.playback.stops import Stops
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.score.motion import Pose
from improv_core.score.profiles import Profile
from improv_core.score.score import Part
from improv_core.stage.protocol import PageRequest, State, TransportMessage, Watched, When
from improv_core.stage.sinks.simulator import Simulator
from improv_core.stage.tickets import issue
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
TOKEN = "a token"


def part(robot: str, start: Pose) -> Part:
    return Part(robot, (), Profile("disc", step=2.0), start, f"/{robot}/cmd_vel")


@pytest.fixture
def commands() -> queue.SimpleQueue[PageRequest | Watched]:
    return queue.SimpleQueue()


@pytest.fixture
def simulator() -> Simulator:
    return Simulator()


@pytest.fixture
def viewer(simulator: Simulator, commands: queue.SimpleQueue[PageRequest | Watched]) -> Iterator[Viewer]:
    viewer = Viewer(0, simulator.snapshot, lambda command: commands.put(command), token=TOKEN)
    yield viewer
    viewer.close()


def link(viewer: Viewer) -> str:
    """A URL that opens the page once."""
    return f"{viewer.address}?ticket={issue(TOKEN)}"


def transport(generation: int, state: State, beats: float | None = 8.0, beat: float = 0.0) -> TransportMessage:
    return {
        "type": "transport",
        "generation": generation,
        "restarted": generation,
        "state": state,
        "backend": "simulator",
        "tempo": 60.0,
        "speed": 1.0,
        "beats": beats,
        "beat": beat,
        "performed": beat,
        "muted": [],
        "soloed": [],
        "monotonic": time.monotonic(),
        "wall": time.time(),
    }


class Show:
    """A simulator's stage that plays programs, as an editor has it, run by an event loop on a thread of its own."""

    def __init__(self) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever)
        self._thread.start()
        self._playback = Playback(Options(backend="sim", takes_start_poses=True), lambda message, leads: None, Stops())

    def play(self, program: str, robots: str = "", when: When = "restart") -> None:
        analysis = analyze(program, read_robots(robots))
        assert analysis.ok
        self._run(lambda: self._playback.play(score_of(analysis), "dance", self._playback.stops.count, when))

    @property
    def url(self) -> str:
        """It opens the page once."""
        link = self._playback.link()
        assert link
        return link

    def end_stage(self) -> None:
        """As if it had never been started: only what is played next starts another."""
        self._run(self._playback.close)

    def close(self) -> None:
        self._run(self._playback.close)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def _run(self, what: Callable[[], Any]) -> None:
        asyncio.run_coroutine_threadsafe(what(), self._loop).result(LIMIT)


@pytest.fixture
def show() -> Iterator[Show]:
    show = Show()
    yield show
    show.close()


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
    page.on("pageerror", lambda error: wrong.append(f"{error} {error.stack}"))
    yield page
    page.close()
    assert wrong == []


@pytest.fixture
def artifacts() -> Path:
    folder = Path(os.environ.get("IMPROV_ARTIFACTS") or Path(__file__).parents[3] / ".artifacts")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def watch(page: Page, show: Show) -> Page:
    """Open the page of a show, and wait until it knows what is to come."""
    page.goto(show.url)
    wait(page, "window.improv?.connected && Object.keys(improv.known).length > 0")
    return page


def wait(page: Page, condition: str) -> None:
    """Look at every frame until the condition holds. (Playwright's own waiting needs eval, which the page forbids.)"""
    page.evaluate(
        f"""() => new Promise((done, fail) => {{
          let looks = 0
          const look = () => (looks++, {condition}) ? done() : requestAnimationFrame(look)
          const seen = () => `${{looks}} frames, ${{JSON.stringify([window.improv?.transport, window.improv?.robots])}}`
          setTimeout(() => fail(new Error(`too late: ${{seen()}}`)), {LIMIT * 1000})
          look()
        }})"""
    )
