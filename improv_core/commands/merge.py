"""`improv merge`: several programs as one."""

from __future__ import annotations

from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.echo import echo, echo_text
from improv_core.commands.programs import files_in, write_new
from improv_core.ide.merging import Dance, merge
from improv_core.program.files import ENDING, analyze_file


@click.command("merge")
@parameters.files
@click.option("--output", "-o", type=click.Path(path_type=Path), help="Write a new file; default: standard output.")
def command(files: tuple[Path, ...], output: Path | None) -> None:
    """Merge programs into one, in which all play side by side.

    Each robot gets its program's name and plays what it plays alone. FILES are programs or folders of programs.
    """
    sources = [Dance(path.stem, analyze_file(path)) for path in files_in(files, ENDING)]
    merged = merge(sources)
    for note in merged.notes:
        echo(f"improv: {note}", err=True)
    if output is None:
        echo_text(merged.text)
        return
    write_new(output, merged.text)
    echo(f"merged {len(sources)} programs into {output}")
