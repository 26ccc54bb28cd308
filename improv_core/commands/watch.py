"""`improv watch`: a program, played again every time it is saved."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
from collections.abc import AsyncIterator, Iterator
from pathlib import Path
from typing import NamedTuple

import click

from improv_core.commands import parameters
from improv_core.commands.exit_codes import INTERRUPTED, CommandError
from improv_core.commands.terminal import Performance, first, performance, run
from improv_core.playback.start import Options
from improv_core.program.analysis import analyze
from improv_core.program.files import STANDARD_INPUT, ReadError, read_program, robots_near
from improv_core.program.report import Mistake, as_lines, mistakes
from improv_core.robots.config import find_robots_file
from improv_core.stage.protocol import When

NEVER = -1
"""A count of stops that there never was: nothing plays that was asked for then."""
STEP, LOOK_AGAIN = 10, 500
"""Milliseconds from a change in a watched folder to a look at the file, and between two looks without a change."""
SETTLING, MID_LINE_SETTLING, EMPTY_SETTLING = 0.1, 0.5, 5.0
"""Seconds that a file must stay unchanged before it is played: longer if it ends in the middle of a line, since it may
be half written, and longest if it is empty, missing or not text, since somebody may still be writing it."""


@click.command("watch")
@parameters.file
@parameters.backend
@parameters.port
@parameters.no_browser
@click.option(
    "--continue", "continues", is_flag=True, help="Robots whose part a save does not change dance on, untouched."
)
def command(file: Path, backend: str, port: int, no_browser: bool, continues: bool) -> None:
    """Play a program every time it is saved. Ctrl-C stops the robots."""
    if file == STANDARD_INPUT:
        raise CommandError("standard input can't be watched: name a file, or use `improv play -`")
    when: When = "beat" if continues else "restart"
    sys.exit(run(watch(file, parameters.options(file, backend, port), when, browser=not no_browser)))


async def watch(path: Path, options: Options, when: When, *, browser: bool) -> int:
    """Play a program, and again at every save, until interrupted; the exit code. Raises ReadError and StageError.

    A save takes effect as `when` says. A program that does not exist yet is waited for, if its folder exists.
    """
    saved = _saved_or_awaited(path)
    async with performance(options, browser=browser) as performing:
        await first(_follow(performing, path, saved, when), performing.interrupted.wait())
    return INTERRUPTED


async def _follow(performing: Performance, path: Path, saved: _Saved, when: When) -> None:
    if saved.text is None:
        performing.present(path)
        performing.say(f"waiting for {path.name}: save it to play it")
    else:
        await _play(performing, path, saved, 0, when)
    async for _ in _changes(path.parent):
        asked = performing.stops.count
        if _saved(path) != saved and (settled := await _settled(path)) != saved:
            saved = settled
            # A stop may also have come between a save and the notice of it, for example while a program was analyzed.
            late = _changed(path) < performing.stops.latest
            await _play(performing, path, saved, NEVER if late else asked, when)


async def _play(performing: Performance, path: Path, saved: _Saved, asked: int, when: When) -> None:
    """Play what was saved, or say why it can't be played."""
    try:
        if saved.text is None:
            raise ReadError(saved.problem)
        analysis = analyze(saved.text, robots_near(path.parent))
    except ReadError as problem:
        performing.complain(f"improv: {problem}")
        performing.present(path, [Mistake(path.name, 0, 0, "", str(problem))])
    else:
        for line in as_lines(path, analysis):
            performing.complain(line)
        if analysis.ok:
            await performing.play(analysis, path, asked, when)
            return
        performing.present(path, mistakes(path, analysis))
    if performing.is_playing:
        performing.say("✗ the previous dance keeps playing")
    else:
        performing.say("✗ nothing is playing: fix the program and save")


class _Saved(NamedTuple):
    """A program as it was saved, or why it can't be read; and when it and its `improv.toml` were saved, in ns.

    So a save that changes nothing counts as well.
    """

    text: str | None
    problem: str
    times: tuple[int, ...]


def _saved(path: Path) -> _Saved:
    times = tuple(state.st_mtime_ns for state in _states(path))
    try:
        return _Saved(read_program(path), "", times)
    except ReadError as problem:
        return _Saved(None, str(problem), times)


def _changed(path: Path) -> int:
    """Unix time of the latest save, in nanoseconds."""
    # On Windows, st_ctime is the time of creation; elsewhere, only it tells when a file was moved to this place.
    return max((each.st_mtime_ns if os.name == "nt" else each.st_ctime_ns for each in _states(path)), default=0)


def _states(path: Path) -> Iterator[os.stat_result]:
    """Of a program and its `improv.toml`, as far as they exist."""
    for file in (path, find_robots_file(path.parent)):
        with contextlib.suppress(OSError):
            if file:
                yield file.stat()


def _saved_or_awaited(path: Path) -> _Saved:
    """A program as it was saved, or none if it is missing from a folder that exists. Raises ReadError."""
    saved = _saved(path)
    if saved.text is None and (path.exists() or not path.parent.is_dir()):
        raise ReadError(saved.problem)
    return saved


async def _changes(folder: Path) -> AsyncIterator[object]:
    """Yields whenever a folder may have changed; it may be removed and come back.

    A folder that can't be watched is polled.
    """
    from watchfiles import awatch

    # The folder is watched instead of the file, since many editors save by replacing the file. Polling finds what the
    # system did not report: saves before watching began, and saves over a network.
    while True:
        with contextlib.suppress(OSError):
            async for changes in awatch(
                folder, recursive=False, yield_on_timeout=True, step=STEP, rust_timeout=LOOK_AGAIN
            ):
                yield changes
        await asyncio.sleep(LOOK_AGAIN / 1000)
        yield None


async def _settled(path: Path) -> _Saved:
    """A program once it no longer changes: half of one may be a program too, and not every editor saves in one step."""
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
