"""`improv watch`: plays a program again every time it is saved. Only the command imports what plays."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from improv_core.commands import parameters, settings
from improv_core.commands.exit_codes import CommandError
from improv_core.commands.parameters import LiveOptions
from improv_core.commands.settings import PlaySettings


@click.command("watch")
@parameters.file
@parameters.live
@parameters.osc_network
@settings.options
@parameters.continues
@parameters.at_bar
@parameters.force
def command(file: Path, live: LiveOptions, settings: PlaySettings) -> None:
    """Play a program every time it is saved. Ctrl-C stops the robots."""
    from improv_core.commands.terminal import run
    from improv_core.commands.watching import watch
    from improv_core.program.files import STANDARD_INPUT

    if file == STANDARD_INPUT:
        raise CommandError("standard input can't be watched: name a file, or use `improv play -`")
    sys.exit(run(watch(file, live.options(file), settings, browser=live.browser)))
