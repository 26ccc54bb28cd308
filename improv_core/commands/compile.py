"""`improv compile`: the velocities that programs compile to, as JSON."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.echo import echo_json
from improv_core.commands.programs import report_each
from improv_core.program.analysis import Analysis
from improv_core.program.compiler import compiled
from improv_core.program.report import as_json


@click.command("compile")
@parameters.files
@click.option("--format", "_layout", type=click.Choice(["json"]), default="json", help="Output: one line per file.")
@click.option(
    "--max-segments", type=click.IntRange(min=1), default=10_000, show_default=True, help="Most segments per robot."
)
def command(files: tuple[Path, ...], _layout: str, max_segments: int) -> None:
    """Print the velocities that programs compile to. Exit code 1 if any has errors."""

    def report(path: Path, analysis: Analysis) -> None:
        line = {"file": str(path), **compiled(analysis, max_segments), "diagnostics": as_json(analysis)}
        echo_json(line)

    sys.exit(report_each(files, report))
