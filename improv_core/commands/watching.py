"""Plays a program again every time it is saved."""

from __future__ import annotations

from pathlib import Path

from improv_core.commands.exit_codes import INTERRUPTED
from improv_core.commands.settings import PlaySettings
from improv_core.commands.terminal import TerminalSession, first, performance
from improv_core.program.analysis import analyze
from improv_core.program.files import ReadError, outputs_near, robots_near
from improv_core.program.report import Mistake
from improv_core.session.start import Options
from improv_core.storage.saves import Saved, changes, read_saved, saved_or_awaited, settle
from improv_core.storage.stopped_saves import StopWitness, Verdict, decide, is_shared, look

ANSWERS = {
    Verdict.DROP: "■ {} was stopped before it began",
    Verdict.SAVE_AGAIN: "■ {} may have been saved before the stop: save again to play it",
    Verdict.ONLY_ROBOTS: "improv.toml has changed: save {} to play again",
}
"""Reasons why a change does not play."""


async def watch(path: Path, options: Options, settings: PlaySettings, *, browser: bool) -> int:
    """Play a program, and again at every save, until interrupted. Return the exit code. Raises ReadError and
    StageError.

    If the program does not exist yet, but its folder does, wait for it.
    """
    saved = saved_or_awaited(path)
    begins_with = "" if saved.text is None else path.name
    outputs = outputs_near(path.parent) if options.backend == "ros" else frozenset()
    async with performance(
        options, browser=browser, settings=settings, begins_with=begins_with, hosts=outputs
    ) as performing:
        performing.stays = True
        await first(_follow(performing, path, saved), performing.interrupted.wait())
    return INTERRUPTED


async def _follow(performing: TerminalSession, path: Path, saved: Saved) -> None:
    stops = performing.stops
    witness, handled = StopWitness(stops, path), look(path)
    played = told = 0  # the counts of stops at the latest play, and when a line last asked to save again
    if saved.text is None:
        performing.present(path)
        performing.screen.say(f"waiting for {path.name}: save it to play it")
    else:
        await _play(performing, path, saved, 0)
    async for _ in changes(path.parent):
        if read_saved(path) == saved or (settled := await settle(path, saved)) == saved:
            continue
        # Stops before these counts are known below; a later stop keeps the save from playing.
        asked, heard, now = stops.count, stops.stopped, look(path)
        at_stop = await witness.since(played)
        verdict = decide(handled, at_stop, now, shared=is_shared(path), told=played < told == stops.stopped)
        saved, handled = settled, now
        if verdict is Verdict.PLAY:
            played = heard
            await _play(performing, path, saved, asked)
        else:
            performing.screen.say(ANSWERS[verdict].format(path.name))
            told = heard if verdict is Verdict.SAVE_AGAIN else told


async def _play(performing: TerminalSession, path: Path, saved: Saved, asked: int) -> None:
    """Play a saved program, or print why it can't play."""
    try:
        if saved.text is None:
            raise ReadError(saved.problem)
        robots = robots_near(path.parent)
        if robots.text != (saved.robots or ""):
            return  # it has just changed, and may be half written: that plays once it has settled
        analysis = analyze(saved.text, robots)
    except ReadError as problem:
        performing.screen.complain(f"improv: {problem}")
        performing.refuse(path, [Mistake(path.name, 0, 0, "", str(problem))])
    else:
        await performing.play_if_right(analysis, path, asked)
