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
from improv_core.commands.programs import code_of, read_each
from improv_core.diagnostics import Diagnostic, Severity
from improv_core.program import room
from improv_core.program.analysis import Analysis
from improv_core.program.files import ENDING
from improv_core.program.joint_check import check_joints
from improv_core.program.report import as_annotation, as_json, as_line
from improv_core.robots.config import FILE_NAME, absolute
from improv_core.stage.dry_run import predict
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
    code = count = 0
    what = "programs"
    told = set[Path]()
    for path, found in read_each(files, ENDING, FILE_NAME):
        code, count = max(code, code_of(found)), count + 1
        if isinstance(found, Analysis):
            _report_program(layout, path, found)
            robots = found.config if found.config.diagnostics else None
        else:
            robots = found
            what = "files"
        # Several programs may share an `improv.toml`.
        if robots and robots.path and absolute(robots.path) not in told:
            told.add(absolute(robots.path))
            _report(layout, robots.path, LineIndex(robots.text), robots.ok, robots.diagnostics)
    if code == 0 and layout == "text" and sys.stdout.isatty():  # standard output has only problems, for programs
        echo("no errors" if count == 1 else f"no errors in {count} {what}")
    sys.exit(code)


def _report_program(layout: str, path: Path, analysis: Analysis) -> None:
    checked = room.check(analysis, predict=predict)
    found = [*analysis.diagnostics, *(checked.diagnostics if checked else ()), *check_joints(analysis)]
    _report(layout, path, analysis.lines, analysis.ok, sorted(found, key=lambda each: each.span), checked)
    if checked and layout != "json":
        # Not on standard output, where other programs read only problems.
        what = "meetings and hits are" if checked.diagnostics else "no robot meets or hits anything:"
        echo(f"{path}: {what} {checked}", err=True)


def _report(
    layout: str,
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
        if layout == "github":
            echo(as_annotation(path, lines, diagnostic))
        else:
            _print_excerpt(path, lines, diagnostic)


def _print_excerpt(path: Path, lines: LineIndex, diagnostic: Diagnostic) -> None:
    room = shutil.get_terminal_size((WIDEST, 0)).columns - len(INDENT) - len("……")
    line, carets = excerpt(lines, diagnostic.span, max(room, NARROWEST))
    echo(as_line(path, lines, diagnostic))
    echo(INDENT + line)
    echo(INDENT + carets, color=_COLORS.get(diagnostic.severity))
