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
from improv_core.program import room
from improv_core.program.analysis import Analysis
from improv_core.program.joint_check import check_joints
from improv_core.program.report import as_annotation, as_json, as_line
from improv_core.robots.config import Robots, absolute
from improv_core.text import LineIndex

INDENT = "    "
WIDEST, NARROWEST = 120, 40
"""Cells of a line without a terminal, and of one in a terminal that is too narrow to show more."""
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
    """Check programs for errors, and whether robots meet or hit something. Exit code 1 if any has errors.

    FILES are programs, improv.toml files, folders of both, or - for standard input.
    """
    told = set[Path]()
    programs = others = 0

    def tell(
        path: Path,
        lines: LineIndex,
        ok: bool,
        diagnostics: Sequence[Diagnostic],
        checked: room.RoomReport | None = None,
    ) -> None:
        if layout == "json":
            diagnosed = {"file": str(path), "ok": ok, "diagnostics": as_json(diagnostics, lines)}
            echo_json({**diagnosed, "checked": checked.as_json()} if checked else diagnosed)
            return
        for diagnostic in diagnostics:
            (_print_annotation if layout == "github" else _print_excerpt)(path, lines, diagnostic)

    def tell_robots(robots: Robots) -> None:
        """Print the errors of an `improv.toml`, once: several programs may share it."""
        if robots.path and absolute(robots.path) not in told:
            told.add(absolute(robots.path))
            tell(robots.path, LineIndex(robots.text), robots.ok, robots.diagnostics)

    def report(path: Path, analysis: Analysis) -> None:
        nonlocal programs
        programs += 1
        checked = room.check(analysis)
        found = [*analysis.diagnostics, *(checked.diagnostics if checked else ()), *check_joints(analysis)]
        tell(path, analysis.lines, analysis.ok, sorted(found, key=lambda each: each.span), checked)
        if checked and layout != "json":
            # Not on standard output, where other programs read only problems.
            echo(f"{path}: the robots' meetings are {checked}", err=True)
        if analysis.config.diagnostics:
            tell_robots(analysis.config)

    def report_robots(robots: Robots) -> None:
        nonlocal others
        others += 1
        tell_robots(robots)

    code = report_each(files, report, report_robots)
    if code == 0 and layout == "text" and sys.stdout.isatty():  # standard output has only problems, for programs
        checked = programs + others
        echo("no errors" if checked == 1 else f"no errors in {checked} {'files' if others else 'programs'}")
    sys.exit(code)


def _print_excerpt(path: Path, lines: LineIndex, diagnostic: Diagnostic) -> None:
    room = shutil.get_terminal_size((WIDEST, 0)).columns - len(INDENT) - len("……")
    line, carets = excerpt(lines, diagnostic.span, max(room, NARROWEST))
    echo(as_line(path, lines, diagnostic))
    echo(INDENT + line)
    echo(INDENT + carets, color=_COLORS.get(diagnostic.severity))


def _print_annotation(path: Path, lines: LineIndex, diagnostic: Diagnostic) -> None:
    echo(as_annotation(path, lines, diagnostic))
