"""`improv new`: a file with a small program, to start from."""

from __future__ import annotations

from pathlib import Path

import click

from improv_core.commands.echo import echo


@click.command("new")
@click.argument("name", required=False, type=click.Path(path_type=Path))
def command(name: Path | None) -> None:
    """Make a small program to start from.

    Without NAME, it is dance.improv or the next free name.
    """
    make(name and with_ending(name))


def with_ending(name: Path) -> Path:
    """Return the name of a program, with the usual ending if it has none."""
    from improv_core.program.files import ENDING

    return name if name.suffix or not name.name else name.with_name(name.name + ENDING)


def make(path: Path | None) -> Path:
    """Make a small program, with the first free name if none is given. Raises WriteError."""
    from improv_core.storage.program_file import create

    made = create(path)
    echo(f"made {made}")
    return made
