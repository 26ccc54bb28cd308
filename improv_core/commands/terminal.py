"""A performance in a terminal: its status, the beat, and its problems. For `play`, `watch` and `record`."""

from __future__ import annotations

import asyncio
import contextlib
import signal
import threading
from collections.abc import AsyncIterator, Awaitable, Callable, Coroutine, Iterable
from dataclasses import replace
from datetime import datetime, timezone
from pathlib import Path
from typing import Any, assert_never

from improv_core import STARTED
from improv_core.commands.exit_codes import INTERRUPTED
from improv_core.commands.keys import Keyboard, pressed
from improv_core.commands.results import Results
from improv_core.commands.screen import Screen
from improv_core.commands.settings import PlaySettings
from improv_core.ide.selection import UnplayableError
from improv_core.outputs.recording.recorder import Recorder
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import score_of
from improv_core.program.files import PlayedRobots, ReadError
from improv_core.program.report import Mistake, as_lines, mistakes, summary
from improv_core.protocol.limits import MEASURED_AT_REST
from improv_core.protocol.messages import Decided, Misplaced, Ready, Sensed, Sent, TransportMessage
from improv_core.protocol.robot_messages import Measured
from improv_core.robots.config import absolute
from improv_core.safety.preflight import NAMED
from improv_core.safety.stop_socket import listening
from improv_core.safety.stops import Stops
from improv_core.score.score import Host
from improv_core.session.acts import News
from improv_core.session.session import Edit, Playback
from improv_core.session.start import Options
from improv_core.session.state import PlayScore
from improv_core.slices import on_checkpoint
from improv_core.storage.history import keep

BROWSER_LIMIT = 5.0
"""Seconds to wait for a browser to show the page, so that nobody misses the first beat."""
USUAL = PlaySettings()


def run(command: Coroutine[Any, Any, int]) -> int:
    """Run a command that plays, and return its exit code."""
    try:
        return asyncio.run(command)
    except asyncio.CancelledError:  # it was interrupted, and has closed
        return INTERRUPTED


async def first(*several: Awaitable[Any]) -> None:
    """Wait until one of several is done, or gives up, and cancel the others. Raises the exception of the first."""
    tasks = [asyncio.ensure_future(each) for each in several]
    done, pending = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    for task in pending:
        task.cancel()
    await asyncio.gather(*pending, return_exceptions=True)
    for task in done:
        if not task.cancelled():
            task.result()


@contextlib.asynccontextmanager
async def performance(
    options: Options,
    *,
    browser: bool,
    quiet: bool = False,
    recorder: Recorder | None = None,
    hears_keys: bool = True,
    edit: Edit | None = None,
    settings: PlaySettings = USUAL,
    begins_with: str = "",
    hosts: frozenset[Host] = frozenset(),
) -> AsyncIterator[TerminalSession]:
    """Yield a performance with its stages started, also those of these hosts, and close it in the end. Raises
    StageError, and as `close` does.

    `begins_with` is the name of the program that plays first: `improv stop` reports it while stages start.
    """
    performing = TerminalSession(options, settings, quiet, recorder, edit)
    performing.playback.begins_with = begins_with
    reached = listening(performing.playback.stop, performing.stops, STARTED)
    if performing.stops.unreachable:
        performing.screen.complain(f"improv: `improv stop` won't work: {performing.stops.unreachable}")
    loop = asyncio.get_running_loop()
    interrupts: list[int] = []

    def interrupt(number: int, _: object) -> None:
        interrupts.append(number)
        # Not a handler of the event loop, which may be busy with a long program; and on a thread, since the interrupted
        # code may be sending something itself.
        threading.Thread(target=performing.stops.stop, daemon=True).start()
        with contextlib.suppress(RuntimeError):  # the loop is closed
            loop.call_soon_threadsafe(performing.interrupted.set)

    def give_up() -> None:
        if interrupts:
            raise asyncio.CancelledError  # nobody waits for the analysis

    on_checkpoint(give_up)
    before = {number: signal.signal(number, interrupt) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        await first(performing.open(browser, hosts), performing.interrupted.wait())
        keys = performing.keyboard
        with pressed(keys.functions()) if hears_keys else contextlib.nullcontext(False) as hears:
            keys.show(hears)
            yield performing
    finally:
        on_checkpoint(None)
        await performing.close()
        if reached:
            reached.close()
        for number, handler in before.items():
            signal.signal(number, handler)


class TerminalSession:
    """A performance shown in a terminal. A failed write to the terminal counts as an interrupt."""

    def __init__(
        self,
        options: Options,
        settings: PlaySettings = USUAL,
        quiet: bool = False,
        recorder: Recorder | None = None,
        edit: Edit | None = None,
    ) -> None:
        self._settings = settings
        self.stops = Stops()
        self.playback = Playback(options, self._hear, self.stops, edit=edit)
        self.results = Results()
        self.rehearses = False
        """True if the latest performance doesn't begin at the starts of its program."""
        self._played_robots = PlayedRobots()
        self._recorder = recorder
        self._not_recorded: OSError | ValueError | None = None
        self._keeping: set[asyncio.Task[None]] = set()  # programs being saved in the history
        self.stays = False
        """True if it doesn't end with a stop that nobody asked for, where a key has robots continue."""
        self.follow: Callable[[TransportMessage], None] = lambda transport: None
        """Gets each message of the leading stage about its position."""
        self._watched = asyncio.Event()  # somebody has opened the page
        self.finished = asyncio.Event()
        self.interrupted = asyncio.Event()
        self.broken = asyncio.Event()  # a stage has ended by itself
        self.refused = asyncio.Event()  # robots are misplaced or too near, and nobody can have them continue here
        # If nobody can read the messages about the robots, the robots stop; `main` prints the reason.
        self.screen = Screen(quiet, self.interrupted.set, rings=settings.bell)
        self.keyboard = Keyboard(lambda: self.playback, self.screen)

    @property
    def has_page(self) -> bool:
        return self.playback.state.page is not None

    @property
    def _page(self) -> Ready | None:
        """The first message of the process with the page."""
        state = self.playback.state
        return state.stages[state.pages[0]].ready if state.pages else None

    async def open(self, browser: bool, hosts: frozenset[Host] = frozenset()) -> None:
        """Start the stages, and show the page in a browser if there is a page and a browser."""
        self.screen.watch()
        await self.playback.open(hosts)
        if self.has_page:
            self.screen.say(f"watch it at {self.playback.link()}")
        if browser and await self.keyboard.open_page():
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._watched.wait(), BROWSER_LIMIT)

    async def play(self, analysis: Analysis, path: Path, asked: int = 0) -> bool:
        """Play a program, or the wanted scenes of it, unless a stop has come since the count of stops was `asked`.

        Return whether it begins. Raises UnplayableError if it lacks these scenes.
        """
        if self.interrupted.is_set():
            return False
        settings = self._settings
        only = settings.chosen(analysis)
        self.rehearses = only.moved
        self.present(path)
        self.finished.clear()
        score = score_of(only.analysis)
        score = replace(score, count_in=score.count_in or settings.count_in)
        if self._recorder:
            self._recorder.prepare(score)
        wanted = PlayScore(score, path.name, asked, settings.when, senses=settings.senses, arming=settings.arming)
        page = self._page
        begins = await self.playback.play(replace(wanted, anyway=settings.anyway))
        if self.has_page and self._page is not page:
            # The stages of hosts were started with another page, which opens by no earlier address.
            self.screen.say(f"watch it at {self.playback.link()}")
        if begins:
            self._keep(path, analysis.text)
            named = f"{only.name}: " if only.name else ""
            self.screen.say(f"▶ {named}{summary(only.analysis)}, {self.playback.state.status}")
            if only.note:
                self.screen.say(only.note)
            return True
        self.screen.say(f"■ {path.name} was stopped before it began")
        self.finished.set()
        return False

    async def play_if_right(self, analysis: Analysis, path: Path, asked: int) -> None:
        """Play a saved program, as `play` does, or print why it can't play."""
        for line in as_lines(path, analysis):
            self.screen.complain(line)
        if not analysis.ok:
            self.refuse(path, mistakes(path, analysis))
            return
        try:
            self._played_robots.check(path, analysis.config)
            await self.play(analysis, path, asked)
        except (UnplayableError, ReadError) as error:
            self.screen.complain(f"improv: {error}")
            self.refuse(path, [Mistake(path.name, 0, 0, "", str(error))])

    def refuse(self, path: Path, mistakes: Iterable[Mistake]) -> None:
        """Print that a saved program can't play, and have the page show the reason."""
        self.playback.begins_with = ""
        self.present(path, mistakes)
        if self.playback.state.is_on:
            self.screen.say("✗ the previous dance keeps playing")
        else:
            self.screen.say("✗ nothing is playing: fix the program and save")

    def present(self, path: Path, mistakes: Iterable[Mistake] = ()) -> None:
        """Have the page show the program that should play, and the errors that prevent it."""
        self.playback.present(path.name, str(absolute(path).parent), mistakes)

    async def settle(self) -> None:
        """If robots' poses are measured, wait until the robots rest, and print their errors."""
        if self.results.errors.robots:
            await asyncio.sleep(MEASURED_AT_REST)
            for line in self.results.errors.lines():
                self.screen.say(line)

    async def close(self) -> None:
        """Stop the robots, then the stages. Raises OSError or ValueError if the recording failed."""
        self.screen.close()
        await self.playback.close()
        await asyncio.gather(*self._keeping, return_exceptions=True)
        if self._not_recorded:
            raise self._not_recorded

    def _keep(self, path: Path, text: str) -> None:
        """Keep a program that plays in the history; only `close` waits for that."""
        kept = asyncio.create_task(asyncio.to_thread(keep, str(absolute(path)), text, datetime.now(timezone.utc)))
        self._keeping.add(kept)
        kept.add_done_callback(self._kept)

    def _kept(self, keeping: asyncio.Task[None]) -> None:
        self._keeping.discard(keeping)
        if problem := keeping.exception():
            self.screen.complain(f"improv: {problem}")

    def report(self) -> dict[str, Any]:
        """Report the results of the latest program."""
        played = self.playback.state.played
        return self.results.as_json(played.score if played else None)

    def _hear(self, message: News, leads: bool) -> None:
        match message["type"]:
            case "transport":
                self._follow(message, leads)
            case "stopped":
                self.results.keep_poses(message)
            case "page_opened":
                self._watched.set()
            case "link":
                self.results.errors.take_link(message)
            case "warning" | "error":
                self._complain(message["message"])
                if message["type"] == "error" and self.broken.is_set():  # no other stage could be started
                    self.finished.set()
            case "gone":
                self._complain(message["message"])
                self.broken.set()
                if not self._is_offered:
                    self.finished.set()
            case _ if not leads:
                pass
            case "measured":
                self.results.measure(message)
                self._record(message)
            case "sent" | "sensed" | "decided":
                self._record(message)
            case "fault":
                self.results.errors.note(message)
                if message["line"]:
                    self._complain(message["line"])
            case "unreached":  # even after an interrupt: somebody has to look
                self.screen.complain(f"improv: {message['message']}")
            case "armed":
                self.keyboard.take_armed(message)
            case "misplaced":
                self._show_misplaced(message)
            case "ready" | "joints" | "vitals" | "place" | "form" | "tune":
                pass  # shown on the page, or in an editor
            case "request" | "seen" | "pressed" | "deserted" | "pong" | "obeyed" | "lacks":
                pass  # between stages, and between them and the session
            case other:
                assert_never(other)

    def _complain(self, line: str) -> None:
        """Print a problem, unless somebody has interrupted the performance."""
        if not self.interrupted.is_set():
            self.screen.complain(f"improv: {line}")

    def _show_misplaced(self, message: Misplaced) -> None:
        """Give up if robots are not in their places, and nobody can begin anyway on a page."""
        self.results.misplaced = message["robots"]
        if message["robots"] and not self.has_page:
            if len(message["robots"]) > NAMED:  # otherwise the next line names all
                for misplaced in message["robots"].values():
                    self.screen.complain(f"improv: {misplaced['line']}")
            self.refused.set()

    def _follow(self, transport: TransportMessage, leads: bool) -> None:
        self.results.follow(transport, leads)
        if leads:
            self.follow(transport)
            self.screen.count(transport)
            self.keyboard.offer(transport, stays=self.stays and not self.interrupted.is_set())
            if self.keyboard.resumes:
                self.broken.clear()  # another stage can have robots continue
            if transport.get("too_near") and not self.has_page and not self.keyboard.resumes:
                self.refused.set()
        if transport["state"] in ("ended", "stopped") and self.results.is_over and not self._is_offered:
            self.finished.set()

    @property
    def _is_offered(self) -> bool:
        """True if a key has robots continue, or will once another stage has replaced a dead one."""
        return bool(self.keyboard.resumes) or (self.stays and self.keyboard.hears and bool(self.playback.state.stood))

    def _record(self, message: Sent | Sensed | Decided | Measured) -> None:
        if not self._recorder or self._not_recorded:
            return
        try:
            self._recorder.take(message)
        except (OSError, ValueError) as problem:  # raised later: here, it would end the thread that reads the stage
            self._not_recorded = problem
            self.finished.set()
