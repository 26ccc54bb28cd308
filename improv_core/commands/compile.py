"""`improv compile`: the velocities that programs compile to, as JSON."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.echo import echo_json
from improv_core.commands.exit_codes import CommandError
from improv_core.commands.programs import code_of, read_each
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import compiled
from improv_core.program.files import ENDING, read_program
from improv_core.program.report import as_json
from improv_core.program.script import ScriptError, read_script
from improv_core.score.performance import SenseSpan


@click.command("compile")
@parameters.files
@click.option(
    "--max-segments",
    type=click.IntRange(min=1),
    metavar="N",
    default=10_000,
    show_default=True,
    help="Most segments per robot.",
)
@click.option("--senses", type=click.Path(path_type=Path), help="A JSON file of what robots sense; default: nothing.")
def command(files: tuple[Path, ...], max_segments: int, senses: Path | None) -> None:
    """Print the velocities that programs compile to. Exit code 1 if any has errors.

    FILES are programs, folders of programs, or - for standard input.
    """
    script = _script(senses) if senses else ()
    code = 0
    for path, found in read_each(files, ENDING):
        code = max(code, code_of(found))
        if isinstance(found, Analysis):
            line = {
                "file": str(path),
                **compiled(found, max_segments, script),
                "diagnostics": as_json(found.diagnostics, found.lines),
            }
            echo_json(line)
    sys.exit(code)


def _script(path: Path) -> Sequence[SenseSpan]:
    """Read the senses of robots from a file. Raises ReadError and CommandError."""
    try:
        return read_script(read_program(path))
    except ScriptError as problem:
        raise CommandError(f"{path}: {problem}") from None
