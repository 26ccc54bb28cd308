"""`improv edit`: a program that people write on the page, save there, and play. Only the command imports what plays."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import click

from improv_core.commands import parameters, settings
from improv_core.commands.echo import echo
from improv_core.commands.exit_codes import CommandError
from improv_core.commands.new import make, with_ending
from improv_core.commands.parameters import LiveOptions
from improv_core.commands.settings import PlaySettings


@click.command("edit")
@click.argument("file", required=False, type=click.Path(path_type=Path))
@parameters.live
@parameters.osc_network
@settings.options
@parameters.continues
@parameters.at_bar
def command(file: Path | None, live: LiveOptions, settings: PlaySettings) -> None:
    """Write a program on the page in the browser. Ctrl+Enter there saves and plays it.

    Without FILE, this opens the dance*.improv of this folder that was saved last, or makes a new one. Ctrl-C stops
    the robots.
    """
    from improv_core.commands.editing import edit
    from improv_core.commands.terminal import run
    from improv_core.program.files import STANDARD_INPUT
    from improv_core.session.start import usual_port
    from improv_core.storage.atomic_write import real
    from improv_core.storage.program_file import latest, read_version

    if file == STANDARD_INPUT:
        raise CommandError("standard input can't be edited: name a file")
    if file and not file.exists():
        file = with_ending(file)
    if not file and (file := latest()):
        echo(f"opened {file}, saved last here: improv new makes another program")
    if not file or not file.exists():
        file = make(file)
    version = read_version(file)
    options = replace(live.options(file), page=True, usual_port=usual_port(str(real(file))))
    sys.exit(run(edit(file, version, options, settings, browser=live.browser)))
