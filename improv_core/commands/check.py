"""`improv check`: the errors and warnings of programs."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.echo import echo, echo_json
from improv_core.commands.excerpt import excerpt
from improv_core.commands.programs import report_each
from improv_core.diagnostics import Severity
from improv_core.program.analysis import Analysis
from improv_core.program.report import as_json, as_line, problems

INDENT = "    "
WIDEST, NARROWEST = 120, 40
"""Cells of a line where there is no terminal, and of one in a terminal too narrow to show more."""
_COLORS = {Severity.ERROR: "red", Severity.WARNING: "yellow", Severity.INFORMATION: "cyan"}


@click.command("check")
@parameters.files
@click.option(
    "--format", "layout", type=click.Choice(["text", "json"]), default="text", show_default=True, help="Output format."
)
def command(files: tuple[Path, ...], layout: str) -> None:
    """Check programs for mistakes. Exit code 1 if any has errors."""
    sys.exit(report_each(files, _print_json if layout == "json" else _print_text))


def _print_text(path: Path, analysis: Analysis) -> None:
    room = shutil.get_terminal_size((WIDEST, 0)).columns - len(INDENT) - len("……")
    for where, lines, diagnostic in problems(path, analysis):
        echo(as_line(where, lines, diagnostic))
        line, carets = excerpt(lines, diagnostic.span, max(room, NARROWEST))
        echo(INDENT + line)
        echo(INDENT + carets, color=_COLORS.get(diagnostic.severity))


def _print_json(path: Path, analysis: Analysis) -> None:
    checked = {"file": str(path), "ok": analysis.ok, "diagnostics": as_json(analysis)}
    echo_json(checked)
