"""`improv check`: the errors and warnings of programs."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.echo import echo, echo_json
from improv_core.commands.programs import report_each
from improv_core.program.analysis import Analysis
from improv_core.program.report import as_json, as_lines


@click.command("check")
@parameters.files
@click.option(
    "--format", "layout", type=click.Choice(["text", "json"]), default="text", show_default=True, help="Output format."
)
def command(files: tuple[Path, ...], layout: str) -> None:
    """Check programs for mistakes. Exit code 1 if any has errors."""
    sys.exit(report_each(files, _print_json if layout == "json" else _print_text))


def _print_text(path: Path, analysis: Analysis) -> None:
    for line in as_lines(path, analysis):
        echo(line)


def _print_json(path: Path, analysis: Analysis) -> None:
    checked = {"file": str(path), "ok": analysis.ok, "diagnostics": as_json(analysis)}
    echo_json(checked)
