"""`improv play` and `improv watch`: programs on the stage, with a beat counter in the terminal."""

from __future__ import annotations

import asyncio
import contextlib
import json
import signal
import sys
import webbrowser
from collections.abc import AsyncIterator, Awaitable
from pathlib import Path
from typing import Any, NamedTuple

import click

from improv_core.playback.playback import Options, Playback, each_beat
from improv_core.playback.stage_process import Message
from improv_core.program.analysis import Analysis, analyze
from improv_core.program.compiler import score_of
from improv_core.program.files import ReadError, analyze_file, read_program, robots_near
from improv_core.program.report import outcome, summary, told
from improv_core.robots.config import find_robots_file
from improv_core.score.motion import Twist
from improv_core.stage.sinks.recorder import Recorder

BROWSER_LIMIT = 5.0
"""Seconds to wait for a browser to show the page, so that nobody misses the first beat."""
STEP, LOOK_AGAIN = 10, 500
"""Milliseconds from a change in a watched folder to a look at the file, and between two looks without one."""
SETTLING, MID_LINE_SETTLING, EMPTY_SETTLING = 0.1, 0.5, 5.0
"""Seconds that a file must stay as it is before it is played; longer if it ends within a line, as half a file may, and
if there is nothing in it, or it is not there or no text: so it may be before somebody goes on writing."""
WRONG_PROGRAM, CANNOT, INTERRUPTED = 1, 2, 130


async def play(
    path: Path, options: Options, *, browser: bool, report: bool = False, recorder: Recorder | None = None
) -> int:
    """Play a program once; the exit code. Raises ReadError and StageError; OSError and ValueError if unrecorded."""
    analysis = analyze_file(path)
    tell_diagnostics(path, analysis)
    if not analysis.ok:
        return WRONG_PROGRAM
    async with _on_stage(options, browser=browser, quiet=report, recorder=recorder) as show:
        await show.play(analysis)
        await _first(show.finished.wait(), show.interrupted.wait())
    if report:
        click.echo(json.dumps(show.report()))
    return INTERRUPTED if show.interrupted.is_set() else CANNOT if show.broken else 0


async def watch(path: Path, options: Options, *, browser: bool) -> int:
    """Play a program, and again at every save, until interrupted; the exit code. Raises ReadError and StageError.

    One that is not there yet is waited for, in a folder that is.
    """
    saved = _saved_or_awaited(path)
    async with _on_stage(options, browser=browser, quiet=False) as show:
        await _first(_follow(show, path, saved), show.interrupted.wait())
    return INTERRUPTED


async def _follow(show: _Show, path: Path, saved: _Saved) -> None:
    if saved.text is None:
        show.say(f"{path.name} is not there yet: save it, and it plays")
    else:
        await _play_if_right(show, path, saved)
    async for _ in _changes(path.parent):
        if _saved(path) != saved and (settled := await _settled(path)) != saved:
            saved = settled
            await _play_if_right(show, path, saved)


class _Saved(NamedTuple):
    """A program as it was saved, or why there is none, and when it and its `improv.toml` were, in ns.

    So a save plays also if it changes nothing.
    """

    text: str | None
    problem: str
    times: tuple[int, ...]


def _saved(path: Path) -> _Saved:
    times = []
    for file in (path, find_robots_file(path.parent)):
        with contextlib.suppress(OSError):
            times += [file.stat().st_mtime_ns] if file else []
    try:
        return _Saved(read_program(path), "", tuple(times))
    except ReadError as problem:
        return _Saved(None, str(problem), tuple(times))


def _saved_or_awaited(path: Path) -> _Saved:
    """A program as it was saved, or none if its folder is there and it is not. Raises ReadError."""
    saved = _saved(path)
    if saved.text is None and (path.exists() or not path.parent.is_dir()):
        raise ReadError(saved.problem)
    return saved


async def _changes(folder: Path) -> AsyncIterator[object]:
    """Whenever there may be a change in a folder. It may go and come again; one that can't be watched is looked at."""
    from watchfiles import awatch

    # The folder is watched, since many editors save by putting a new file in the old one's place. A look now and then
    # finds what the system did not tell: the save before it was asked to, and those over a network.
    while True:
        with contextlib.suppress(OSError):
            async for changes in awatch(
                folder, recursive=False, yield_on_timeout=True, step=STEP, rust_timeout=LOOK_AGAIN
            ):
                yield changes
        await asyncio.sleep(LOOK_AGAIN / 1000)
        yield None


async def _settled(path: Path) -> _Saved:
    """A program once it is left alone.

    Half of one may be one too, and not every editor, nor any network, puts a file in place all at once.
    """
    clock = asyncio.get_running_loop().time
    latest, since = _saved(path), clock()
    while clock() - since < _settling(latest.text):
        await asyncio.sleep(SETTLING)
        if (now := _saved(path)) != latest:
            latest, since = now, clock()
    return latest


def _settling(text: str | None) -> float:
    if not text:
        return EMPTY_SETTLING
    return SETTLING if text.endswith(("\n", "\r")) else MID_LINE_SETTLING


async def _play_if_right(show: _Show, path: Path, saved: _Saved) -> None:
    show.clear_line()
    analysis = None
    try:
        if saved.text is None:
            raise ReadError(saved.problem)
        analysis = analyze(saved.text, robots_near(path.parent))
        tell_diagnostics(path, analysis)
    except ReadError as problem:
        click.echo(f"improv: {problem}", err=True)
    if analysis and analysis.ok:
        await show.play(analysis)
    else:
        show.say("✗ what plays goes on" if show.is_on else "✗ nothing plays: correct it and save")


def tell_diagnostics(path: Path, analysis: Analysis) -> None:
    for line in told(path, analysis):
        click.echo(line, err=True)


@contextlib.asynccontextmanager
async def _on_stage(
    options: Options, *, browser: bool, quiet: bool, recorder: Recorder | None = None
) -> AsyncIterator[_Show]:
    show = _Show(options, quiet, recorder)
    for number in (signal.SIGINT, signal.SIGTERM):
        with contextlib.suppress(NotImplementedError):  # Windows raises KeyboardInterrupt instead
            asyncio.get_running_loop().add_signal_handler(number, show.interrupted.set)
    try:
        await _first(show.open(browser), show.interrupted.wait())
        yield show
    finally:
        await show.close()


async def _first(*several: Awaitable[Any]) -> None:
    """Wait until one of several is done, and end the others; what it raised is raised."""
    tasks = [asyncio.ensure_future(each) for each in several]
    done, pending = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    for task in pending:
        task.cancel()
    await asyncio.gather(*pending, return_exceptions=True)
    for task in done:
        task.result()


class _Show:
    """What plays, shown in a terminal: its status, the beat, and what goes wrong."""

    def __init__(self, options: Options, quiet: bool, recorder: Recorder | None) -> None:
        self._playback = Playback(options, self._hear)
        self._quiet = quiet
        self._recorder = recorder
        self._unwritten: OSError | ValueError | None = None
        self._counter: asyncio.Task[None] | None = None
        self._counted = False  # whether the cursor stands behind a beat
        self._latest: dict[str, Any] = {}  # of the stage that leads, with the poses of the one that has them
        self._playing: set[str] = set()  # which stages play
        self.finished = asyncio.Event()
        self.interrupted = asyncio.Event()
        self.broken = False  # whether a stage has ended by itself

    @property
    def is_on(self) -> bool:
        return bool(self._playing)

    async def open(self, browser: bool) -> None:
        """Start the stages, and show the page in a browser if there is one of both."""
        await self._playback.open()
        if not self._playback.page:
            return
        self.say(f"watch it on {self._playback.page}")
        if browser and await asyncio.to_thread(webbrowser.open, self._playback.page):
            with contextlib.suppress(asyncio.TimeoutError):
                await asyncio.wait_for(self._playback.watched.wait(), BROWSER_LIMIT)

    async def play(self, analysis: Analysis) -> None:
        if self.interrupted.is_set():
            return
        self.finished.clear()
        score = score_of(analysis)
        if self._recorder:
            self._recorder.prepare(score, restart=True)
        if await self._playback.play(score):
            self.say(f"▶ {summary(analysis)}, {self._playback.status}")

    async def close(self) -> None:
        """Stop the robots, then the stages. Raises OSError or ValueError if what was sent could not be recorded."""
        self._stop_counter()
        await self._playback.close()
        if self._unwritten:
            raise self._unwritten

    def report(self) -> dict[str, Any]:
        """What became of the latest dance."""
        return outcome(self._latest)

    def _hear(self, message: Message, leads: bool) -> None:
        if message["type"] == "transport":
            self._follow(message, leads)
        elif message["type"] == "stopped":
            self._keep_poses(message)
        elif message["type"] == "sent" and leads:
            self._record(message)
        elif message["type"] in ("warning", "error", "gone"):
            if not self.interrupted.is_set():
                self.clear_line()
                click.echo(f"improv: {message['message']}", err=True)
            if message["type"] == "gone":
                self._playing.discard(_role(leads))
                self.broken = True
                self.finished.set()

    def _follow(self, transport: Message, leads: bool) -> None:
        self._keep_poses(transport)
        if leads:
            self._latest.update(transport)
        if transport["state"] == "playing":
            self._playing.add(_role(leads))
        else:
            self._playing.discard(_role(leads))
        if leads:
            self._stop_counter()
            if transport["state"] == "playing" and not self._quiet and sys.stdout.isatty():
                self._counter = asyncio.create_task(self._count(transport))
        if not self._playing and transport["state"] in ("ended", "stopped"):
            self.finished.set()

    def _keep_poses(self, message: Message) -> None:
        self._latest.update({key: message[key] for key in ("start", "poses") if key in message})

    def _record(self, sent: Message) -> None:
        if not self._recorder or self._unwritten:
            return
        try:
            self._recorder.record(sent["robot"], Twist(*sent["twist"]), sent["wall"])
        except (OSError, ValueError) as problem:  # not from here, or no more would be heard of the stage
            self._unwritten = problem
            self.finished.set()

    def _stop_counter(self) -> None:
        if self._counter:
            self._counter.cancel()
            self._counter = None
        if self._counted:
            self._counted = False
            click.echo()

    def clear_line(self) -> None:
        """Make room for a line where the beat is counted; the count goes on below."""
        if self._counted:
            self._counted = False
            click.echo("\r\x1b[K", nl=False)

    async def _count(self, transport: Message) -> None:
        """The beat, in place, until cancelled."""
        async for beat in each_beat(transport):
            self._counted = True
            click.echo(f"\r{beat} ", nl=False)

    def say(self, line: str) -> None:
        if not self._quiet:
            self.clear_line()
            click.echo(line)


def _role(leads: bool) -> str:
    return "leader" if leads else "twin"
