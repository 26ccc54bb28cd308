"""The command line: `improv check`, `compile`, `play` and `watch`."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from improv_core import __version__
from improv_core.analysis import Analysis, analyze
from improv_core.report import as_json, told

WRONG_PROGRAM, CANNOT = 1, 2
"""Exit codes: the program has errors; the command could not be carried out."""


def main() -> None:
    """The `improv` command."""
    for stream in (sys.stdout, sys.stderr):
        # The beat counter and robots' names need more than some terminals' own encoding.
        getattr(stream, "reconfigure", lambda **_: None)(encoding="utf-8", errors="replace")
    improv()


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="improv")
def improv() -> None:
    """Live coding for robot motion: a few words of choreography, and robots move."""


_files = click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
_file = click.argument("file", type=click.Path(path_type=Path))


@improv.command()
@_files
@click.option("--format", "layout", type=click.Choice(["text", "json"]), default="text", help="How to tell it.")
def check(files: tuple[Path, ...], layout: str) -> None:
    """Say what is wrong with programs. Exit code 1 if any has errors."""

    def tell(path: Path, analysis: Analysis) -> None:
        if layout == "json":
            _print_json({"file": str(path), "ok": analysis.ok, "diagnostics": as_json(analysis)})
        else:
            for line in told(str(path), analysis):
                click.echo(line)

    _each(files, tell)


@improv.command("compile")
@_files
@click.option("--format", "layout", type=click.Choice(["json"]), default="json", help="JSON, a line for each file.")
@click.option("--max-segments", type=click.IntRange(min=1), default=10_000, show_default=True, help="For each robot.")
def compile_(files: tuple[Path, ...], layout: str, max_segments: int) -> None:
    """Print the velocities a program compiles to. Exit code 1 if any has errors."""
    from improv_core.compiler import compiled

    def tell(path: Path, analysis: Analysis) -> None:
        _print_json({"file": str(path), **compiled(analysis, max_segments), "diagnostics": as_json(analysis)})

    _each(files, tell)


def read_program(path: Path) -> str:
    """The text of a program. Raises click.ClickException, in one line, if it can't be read."""
    try:
        return path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        problem = "it is not UTF-8 text"
    except OSError as error:
        problem = (error.strerror or "it can't be read").lower()
    raise CannotError(f"{path}: {problem}")


class CannotError(click.ClickException):
    """The command could not be carried out; said in one line."""

    exit_code = CANNOT

    def show(self, file: Any = None) -> None:
        click.echo(f"improv: {self.message}", err=True)


def _each(files: tuple[Path, ...], tell: Callable[[Path, Analysis], None]) -> None:
    """Tell about every file that can be read, then exit by the worst of what happened."""
    code = 0
    for path in files:
        try:
            analysis = analyze(read_program(path))
        except CannotError as problem:
            problem.show()
            code = CANNOT
        else:
            tell(path, analysis)
            code = max(code, 0 if analysis.ok else WRONG_PROGRAM)
    sys.exit(code)


def _print_json(value: Any) -> None:
    click.echo(json.dumps(value, ensure_ascii=False))
