"""`improv play`: a program, once. Completion imports this module, so only the command imports what plays."""

from __future__ import annotations

import sys
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import click

from improv_core.commands import parameters, settings
from improv_core.commands.begin_time import moment
from improv_core.commands.exit_codes import PROBLEMS, CommandError
from improv_core.commands.parameters import LiveOptions
from improv_core.commands.ros_arguments import is_launched
from improv_core.commands.settings import PlaySettings


def _time(text: str) -> datetime:
    """Convert an option that is a time. Raises BadParameter."""
    try:
        return moment(text, datetime.now())
    except ValueError as problem:
        raise click.BadParameter(str(problem)) from None


@click.command("play")
@parameters.file
@parameters.live
@parameters.osc_network
@settings.options
@click.option("--fast", is_flag=True, help="Simulate without the page, as fast as this machine can.")
@click.option("--for", "seconds", type=parameters.SECONDS, help="With --fast, stop after this many seconds.")
@click.option("--senses", "recording", type=parameters.RECORDING, help="Make robots sense what a recording contains.")
@parameters.force
@click.option(
    "--armed", is_flag=True, help="Get everything ready, and begin when somebody presses Space, Enter, or Play."
)
@click.option(
    "--at", "begins", metavar="TIME", type=_time, help="Armed, and begin by itself at 20:15, or at an ISO time."
)
@click.option("--once", is_flag=True, help="End when the dance ends, even in a terminal.")
@click.option("--report", type=click.Choice(["json"]), help="At the end, print where the robots are.")
def command(
    file: Path,
    live: LiveOptions,
    settings: PlaySettings,
    fast: bool,
    seconds: float | None,
    recording: Path | None,
    armed: bool,
    begins: datetime | None,
    once: bool,
    report: str | None,
) -> None:
    """Play a program. Ctrl-C stops the robots.

    FILE is a program, or - for standard input. In a terminal, the page can play it again after it has ended, until
    Ctrl-C.
    """
    from improv_core.commands.playing import play, play_fast, senses_of
    from improv_core.commands.programs import read_to_play
    from improv_core.commands.terminal import run

    if seconds and not fast:
        raise CommandError("--for requires --fast; stop a live run with Ctrl-C")
    if fast and live.backend in ("ros", "both"):
        raise CommandError("--fast works only in the simulator: real robots can't be sped up")
    if fast and (settings.count_in or settings.bell):
        raise CommandError("--fast begins at once: leave out --count-in and --bell")
    if fast and (armed or begins):
        raise CommandError("--fast begins at once: leave out --armed and --at")
    settings = replace(settings, senses=senses_of(recording))
    if fast:
        sys.exit(play_fast(file, seconds, settings, report=report is not None))
    if not (analysis := read_to_play(file)):
        sys.exit(PROBLEMS)
    settings.chosen(analysis)  # before the search for robots
    settings = replace(settings, arming={"begins": begins.timestamp()} if begins else {} if armed else None)
    stays = sys.stdout.isatty() and not (is_launched() or once or report)
    playing = play(
        analysis, file, live.options(file), settings, browser=live.browser, report=report is not None, stays=stays
    )
    sys.exit(run(playing))
