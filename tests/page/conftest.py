"""A real browser, and waits for changes of a page."""

from __future__ import annotations

import asyncio
import os
import queue
import re
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import pytest
from playwright.sync_api import Browser, BrowserContext, ConsoleMessage, FloatRect, Page, expect, sync_playwright

from improv_core.ipc.stage_process import Stage
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.page.server import PageServer
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.commands import PageOpened, PageRequest
from improv_core.protocol.messages import State, ToStage, TransportMessage, When
from improv_core.protocol.tickets import issue
from improv_core.robots.config import Robots, read_robots
from improv_core.safety.stops import Stops
from improv_core.score.motion import Pose
from improv_core.score.movement import ENDLESS
from improv_core.score.profiles import Profile
from improv_core.score.score import Part
from improv_core.session.session import Playback
from improv_core.session.start import Options, StartStage, start_stage
from improv_core.session.state import HERE, PlayScore, StageKey
from tests.axe import violations
from tests.needs import need_headless_chromium
from tests.open_page import CALMLY
from tests.session import story
from tests.stage_on_thread import start_on_thread

if TYPE_CHECKING:
    from tests.page.editing import Edit

__all__ = ["violations"]  # fixtures of others

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
SERVER_IS_GONE = re.compile(
    "net::ERR_(CONNECTION_|SOCKET_NOT_CONNECTED|EMPTY_RESPONSE|INCOMPLETE_CHUNKED_ENCODING|CONTENT_LENGTH_MISMATCH)"
    "|Connection closed before receiving a handshake response"
)
"""Messages of Chromium about a server that closes before it accepts a connection, or before or while it answers.

That is an error to the browser, not to us. Each was seen with a server that closes at that moment.
"""
LIMIT = 120.0
"""Seconds to wait for anything on a busy machine."""
TOKEN = "a token"
Keep = Callable[[Page, str], None]
Commands = queue.SimpleQueue[PageRequest | PageOpened]
"""Requests of pages."""
Scheme = Literal["light", "dark"]
SCHEMES: tuple[Scheme, ...] = ("light", "dark")


def part(robot: str, start: Pose) -> Part:
    return Part(robot, (), Profile("disc", step=2.0), start, f"/{robot}/cmd_vel")


@pytest.fixture
def commands() -> Commands:
    return queue.SimpleQueue()


def asked(commands: Commands) -> dict[str, Any]:
    """Return a page's next request, except that it watches, and its questions."""
    while (command := commands.get(timeout=LIMIT))["type"] in ("page_opened", "window"):
        pass
    return {key: value for key, value in command.items() if key != "at"}


@pytest.fixture
def simulator() -> Simulator:
    return Simulator()


@pytest.fixture
def viewer(simulator: Simulator, commands: Commands) -> Iterator[PageServer]:
    viewer = PageServer(0, simulator.snapshot, lambda command: commands.put(command), token=TOKEN)
    yield viewer
    viewer.close()


def link(viewer: PageServer) -> str:
    """Return a URL that opens the page once."""
    return f"{viewer.address}?ticket={issue(TOKEN)}"


def transport(generation: int, state: State, beats: float | None = 8.0, beat: float = 0.0) -> TransportMessage:
    """Build the position of the simulator's stage in a score of 60 beats a minute."""
    known = {"backend": "simulator", "tempo": 60.0, "beats": beats, "performed": beat, "wall": time.time()}
    return story.at(state, generation, beat, time.monotonic(), **known)


class Show:
    """A simulator's stage that plays programs, as an editor has it, run by an event loop on its own thread.

    The stage is a process, unless it is started otherwise.
    """

    def __init__(self, start: StartStage = start_stage) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever)
        self._thread.start()
        options = Options(backend="sim", takes_start_poses=True)
        self._playback = Playback(options, lambda message, leads: None, Stops(), start)

    def play(
        self, program: str, robots: str = "", when: When = "restart", folder: Path | None = None, **how: Any
    ) -> bool:
        """Play a program, and return whether it was sent; `robots` is its improv.toml, which is in that folder if it
        has to be in one."""
        analysis = analyze(program, read_robots(robots, folder and folder / "improv.toml"))
        assert analysis.ok
        score = score_of(analysis)
        play = PlayScore(score, "dance", self._playback.stops.count, when, **how)
        return self._run(lambda: self._playback.play(play)) is not None

    def tell(self, message: ToStage) -> None:
        """Send the stage a message, as if a stage of real robots led."""
        self._playback._stages[StageKey(HERE, "simulator")].send(message)

    @property
    def url(self) -> str:
        """A URL that opens the page once."""
        link = self._playback.link()
        assert link
        return link

    @property
    def stops(self) -> int:
        """The number of stops that have arrived."""
        return self._playback.stops.count

    @property
    def stage(self) -> int:
        """The number of the process that plays, if it is one."""
        stage = self._playback._stages[StageKey(HERE, "simulator")]
        assert isinstance(stage, Stage)
        return stage._child.pid

    def close(self) -> None:
        self._run(self._playback.close)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def _run(self, what: Callable[[], Any]) -> Any:
        return asyncio.run_coroutine_threadsafe(what(), self._loop).result(LIMIT)


@pytest.fixture
def show() -> Iterator[Show]:
    show = Show(start_on_thread)
    yield show
    show.close()


@dataclass(frozen=True)
class Chromium:
    """A browser, a window in which pages are tabs, and the event loop that both need."""

    browser: Browser
    window: BrowserContext
    loop: asyncio.AbstractEventLoop


@pytest.fixture(scope="session")
def chromium() -> Iterator[Chromium]:
    """Open one browser and window for all tests of a worker: each server has its own port, so pages share nothing.

    One page stays open, because with the last one the window closes: to open it for each test takes half a second.

    That loop runs as long as the browser does. While no test uses the browser, it is hidden: `asyncio.run` of another
    test would refuse to run beside it.
    """
    path = need_headless_chromium()
    with sync_playwright() as playwright:
        # Without a process of its own for what it draws, all tests took 3:12 instead of 3:38, on two processors.
        browser = playwright.chromium.launch(executable_path=path, args=[*FLAGS, "--in-process-gpu"])
        loop = asyncio.get_running_loop()
        window = browser.new_context(viewport={"width": 1280, "height": 800})
        window.add_init_script(CALMLY)
        window.new_page()
        asyncio._set_running_loop(None)
        yield Chromium(browser, window, loop)
        asyncio._set_running_loop(loop)
        browser.close()


@contextmanager
def using(chromium: Chromium) -> Iterator[None]:
    asyncio._set_running_loop(chromium.loop)
    expect.set_options(timeout=LIMIT * 1000)
    yield
    expect.set_options(timeout=None)
    asyncio._set_running_loop(None)


@pytest.fixture
def browser(chromium: Chromium) -> Iterator[Browser]:
    with using(chromium):
        yield chromium.browser


@pytest.fixture
def window(browser: Browser, chromium: Chromium) -> BrowserContext:
    return chromium.window


@pytest.fixture
def lively(browser: Browser) -> Iterator[BrowserContext]:
    """A window whose pages draw as often as for people. Tests that wait for many frames name it `window`."""
    window = browser.new_context(viewport={"width": 1280, "height": 800})
    yield window
    window.close()


@pytest.fixture
def page(window: BrowserContext) -> Iterator[Page]:
    """A page on which no error goes unnoticed."""
    page, wrong = new_page(window)
    yield page
    leave(page)
    assert wrong == []


@pytest.fixture
def edit(tmp_path: Path, window: BrowserContext) -> Iterator[Callable[..., Edit]]:
    """Return a function that edits `dance.improv`, with this text and with more options, by `improv edit`."""
    from tests.page.editing import Edit  # which needs this module

    opened: list[Edit] = []

    def begin(program: str, *options: str) -> Edit:
        file = tmp_path / "dance.improv"
        file.write_bytes(program.encode())
        opened.append(Edit(file, window, *options))
        return opened[-1]

    yield begin
    for each in opened:
        each.close()


def leave(page: Page) -> None:
    """Close a page, and forget its settings: a later server may get the same port."""
    if not page.is_closed():
        page.evaluate("() => { try { localStorage.clear() } catch {} }")
        page.close()


def new_page(window: BrowserContext) -> tuple[Page, list[str]]:
    """Open a page, and collect its errors."""
    wrong: list[str] = []

    def listen(message: ConsoleMessage) -> None:
        if message.type in ("error", "warning") and not SERVER_IS_GONE.search(message.text):
            wrong.append(message.text)

    page = window.new_page()
    page.set_default_timeout(LIMIT * 1000)
    page.on("console", listen)
    page.on("pageerror", lambda error: wrong.append(f"{error} {error.stack}"))
    return page, wrong


@pytest.fixture
def keep() -> Keep:
    """Return a function that keeps a picture of a page under a name, if `IMPROV_ARTIFACTS` names a folder for them. No
    test looks at it."""
    folder = os.environ.get("IMPROV_ARTIFACTS")

    def keep(page: Page, name: str) -> None:
        if folder:
            page.screenshot(path=Path(folder, name))

    return keep


def watch(page: Page, show: Show, program: str = "", robots: str = "", **how: Any) -> Page:
    """Open the page of a show, which plays this program now or plays already, wait until it has the next beats, and put
    the focus on the stage."""
    if program:
        show.play(program, robots, **how)
    page.goto(show.url)
    wait(page, "window.improv?.connected && Object.keys(improv.known).length > 0")
    page.locator("#stage").focus()  # keys work there
    return page


@pytest.fixture
def still(page: Page, viewer: PageServer, simulator: Simulator) -> Callable[..., Page]:
    """Return a function that opens the page of a program that is still at its first beat. There is no stage behind
    it."""

    def open_page(program: str, robots: str | Robots = "") -> Page:
        score = score_of(analyze(program, read_robots(robots) if isinstance(robots, str) else robots))
        simulator.prepare(score, restart=True)
        viewer.show(score, 1)
        viewer.publish(transport(1, "paused", None if score.beats == ENDLESS else float(score.beats)))
        page.goto(link(viewer))
        wait(page, "window.improv?.connected && Object.keys(improv.known).length > 0")
        page.locator("#stage").focus()  # keys work there
        return page

    return open_page


def wait(page: Page, condition: str) -> None:
    """Look at every frame until the condition holds, which may name things that aren't there yet.

    Playwright's own waiting needs eval, which the page forbids.
    """
    page.evaluate(
        f"""() => new Promise((done, fail) => {{
          let looks = 0, error = ''
          const holds = () => {{ try {{ return {condition} }} catch (raised) {{ error = raised; return false }} }}
          const look = () => (looks++, holds()) ? done() : requestAnimationFrame(look)
          const state = () => JSON.stringify([window.improv?.transport, window.improv?.robots])
          const seen = () => `${{looks}} frames, ${{error}}, ${{state()}}`
          setTimeout(() => fail(new Error(`too late: ${{seen()}}`)), {LIMIT * 1000})
          look()
        }})"""
    )


@pytest.fixture(scope="module")
def opened(request: pytest.FixtureRequest, chromium: Chromium) -> Iterator[tuple[Show, Page]]:
    """Open a stage that plays the `PROGRAM` of a file, and a page of it, for several of its tests: to open them takes
    longer than most of these tests. Each test leaves the page as it found it, and begins with `play_anew`."""
    show = Show(start_on_thread)
    show.play(request.module.PROGRAM)
    with using(chromium):
        page, wrong = new_page(chromium.window)
        watch(page, show)
    yield show, page
    with using(chromium):
        leave(page)
    show.close()
    assert wrong == []


@pytest.fixture
def shared(browser: Browser, opened: tuple[Show, Page]) -> tuple[Show, Page]:
    """Return the stage and the page that are `opened` for a file, for one of its tests."""
    return opened


def play_anew(page: Page, show: Show, program: str, robots: str = "", **how: Any) -> None:
    """Begin a program on an open page, which then has the next beats. The stage has the focus."""
    before = page.evaluate("improv.transport.generation")
    show.play(program, robots, **how)
    wait(page, f"improv.transport.generation > {before} && Object.keys(improv.known).length > 0")
    page.locator("#stage").focus()


def begin_paused(page: Page, show: Show, program: str, **how: Any) -> None:
    """Begin a program on an open page, and have it pause at its first beat."""
    play_anew(page, show, program, **how)
    page.keyboard.press("n")  # which pauses, also a short dance that is over already
    wait(page, "improv.transport.state === 'paused'")
    page.keyboard.press("Home")
    wait(page, "improv.transport.state === 'paused' && improv.beat === 0")


def next_frame(page: Page) -> None:
    """Wait until changes are laid out and drawn."""
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def rest(page: Page) -> None:
    """Wait until the page has laid out its changes, and has drawn all that there is: the view stands still."""
    next_frame(page)
    wait(page, "improv.rests")


def switch_to(page: Page, scheme: Scheme) -> None:
    """Switch the page to this color scheme, also its next frame."""
    page.emulate_media(color_scheme=scheme)
    next_frame(page)


def at(page: Page, x: float, y: float) -> tuple[float, float]:
    """Return the place of a point of the world on the page, in pixels; once the view has come to rest."""
    rest(page)
    stage = box(page, "#stage")
    place = page.evaluate(f"improv.toScreen({x}, {y})")
    return stage["x"] + place["x"], stage["y"] + place["y"]


def box(page: Page, selector: str) -> FloatRect:
    """Return where an element is on the page, in pixels."""
    found = page.locator(selector).bounding_box()
    assert found
    return found
