"""`improv watch`: a program, played again every time it is saved."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.exit_codes import INTERRUPTED
from improv_core.commands.terminal import Performance, first, performance, run
from improv_core.playback.start import Options
from improv_core.program.analysis import analyze
from improv_core.program.files import ReadError, robots_near
from improv_core.program.report import Mistake
from improv_core.services.saves import Saved, changed_at, changes, read_saved, saved_or_awaited, settle
from improv_core.stage.protocol import When

NEVER = -1
"""A count of stops that there never was: nothing plays that was asked for then."""


@click.command("watch")
@parameters.file
@parameters.backend
@parameters.port
@parameters.no_browser
@parameters.continues
def command(file: Path, backend: str, port: int, no_browser: bool, when: When) -> None:
    """Play a program every time it is saved. Ctrl-C stops the robots."""
    sys.exit(run(watch(file, parameters.options(file, backend, port), when, browser=not no_browser)))


async def watch(path: Path, options: Options, when: When, *, browser: bool) -> int:
    """Play a program, and again at every save, until interrupted; the exit code. Raises ReadError and StageError.

    A save takes effect as `when` says. A program that does not exist yet is waited for, if its folder exists.
    """
    saved = saved_or_awaited(path)
    async with performance(options, browser=browser) as performing:
        await first(_follow(performing, path, saved, when), performing.interrupted.wait())
    return INTERRUPTED


async def _follow(performing: Performance, path: Path, saved: Saved, when: When) -> None:
    if saved.text is None:
        performing.present(path)
        performing.say(f"waiting for {path.name}: save it to play it")
    else:
        await _play(performing, path, saved, 0, when)
    async for _ in changes(path.parent):
        asked = performing.stops.count
        if read_saved(path) != saved and (settled := await settle(path)) != saved:
            saved = settled
            # A stop may also have come between a save and the notice of it, for example while a program was analyzed.
            late = changed_at(path) < performing.stops.latest
            await _play(performing, path, saved, NEVER if late else asked, when)


async def _play(performing: Performance, path: Path, saved: Saved, asked: int, when: When) -> None:
    """Play what was saved, or say why it can't be played."""
    try:
        if saved.text is None:
            raise ReadError(saved.problem)
        analysis = analyze(saved.text, robots_near(path.parent))
    except ReadError as problem:
        performing.complain(f"improv: {problem}")
        performing.refuse(path, [Mistake(path.name, 0, 0, "", str(problem))])
    else:
        await performing.play_if_right(analysis, path, asked, when)
