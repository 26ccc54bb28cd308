"""`improv new`: a file with a small program, to begin with."""

from __future__ import annotations

from pathlib import Path

import click

from improv_core.commands.echo import echo
from improv_core.commands.exit_codes import CommandError
from improv_core.services.program_file import ENDING, WriteError, create


@click.command("new")
@click.argument("name", required=False, type=click.Path(path_type=Path))
def command(name: Path | None) -> None:
    """Make a small program to begin with: dance.improv, or the next free name."""
    echo(f"made {create_named(name)}")


def create_named(name: Path | None) -> Path:
    """Make a program's file; its name gets the usual ending if it has none. Raises CommandError."""
    try:
        return create(name.with_name(name.name + ENDING) if name and name.name and not name.suffix else name)
    except WriteError as problem:
        raise CommandError(str(problem)) from None
