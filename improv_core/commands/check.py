"""`improv check`: the errors and warnings of programs."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.echo import echo, echo_json
from improv_core.commands.excerpt import excerpt
from improv_core.commands.programs import report_each
from improv_core.diagnostics import Diagnostic, Severity
from improv_core.program.analysis import Analysis
from improv_core.program.report import as_annotation, as_json, as_line, problems
from improv_core.text import LineIndex

INDENT = "    "
WIDEST, NARROWEST = 120, 40
"""Cells of a line if there is no terminal, and of one in a terminal that is too narrow to show more."""
_COLORS = {Severity.ERROR: "red", Severity.WARNING: "yellow", Severity.INFORMATION: "cyan"}


@click.command("check")
@parameters.files
@click.option(
    "--format",
    "layout",
    type=click.Choice(["text", "json", "github"]),
    default="text",
    show_default=True,
    help="Output: for people, a line of JSON per file, or annotations for GitHub Actions.",
)
def command(files: tuple[Path, ...], layout: str) -> None:
    """Check programs for errors. Exit code 1 if any has errors.

    FILES are programs, folders of programs, or - for standard input.
    """
    told = set[Path | None]()
    checked = 0

    def report(path: Path, analysis: Analysis) -> None:
        nonlocal checked
        checked += 1
        robots = analysis.cast
        if layout == "json":
            _print_json(path, analysis.ok, analysis.diagnostics, analysis.lines)
            if robots.diagnostics and robots.path not in told:
                _print_json(robots.path, robots.ok, robots.diagnostics, LineIndex(robots.text))
        else:
            for problem in problems(path, analysis):
                if problem[0] not in told:
                    _print_annotation(*problem) if layout == "github" else _print_excerpt(*problem)
        told.add(robots.path)  # which several programs may share

    code = report_each(files, report)
    if code == 0 and layout == "text" and sys.stdout.isatty():  # what other programs read holds only problems
        echo("no errors" if checked == 1 else f"no errors in {checked} programs")
    sys.exit(code)


def _print_excerpt(path: Path, lines: LineIndex, diagnostic: Diagnostic) -> None:
    room = shutil.get_terminal_size((WIDEST, 0)).columns - len(INDENT) - len("……")
    line, carets = excerpt(lines, diagnostic.span, max(room, NARROWEST))
    echo(as_line(path, lines, diagnostic))
    echo(INDENT + line)
    echo(INDENT + carets, color=_COLORS.get(diagnostic.severity))


def _print_annotation(path: Path, lines: LineIndex, diagnostic: Diagnostic) -> None:
    echo(as_annotation(path, lines, diagnostic))


def _print_json(path: Path | None, ok: bool, diagnostics: Sequence[Diagnostic], lines: LineIndex) -> None:
    echo_json({"file": str(path), "ok": ok, "diagnostics": as_json(diagnostics, lines)})
