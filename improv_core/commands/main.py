"""The command line: `improv check`, `compile`, `format`, `play`, `watch`, `record`, `doctor` and `ros setup`."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from improv_core import __version__
from improv_core.program.analysis import Analysis
from improv_core.program.files import ReadError, analyze_file
from improv_core.program.report import as_json, told

if TYPE_CHECKING:
    from improv_core.playback.playback import Options

WRONG_PROGRAM, CANNOT, INTERRUPTED = 1, 2, 130
"""Exit codes: the program has errors; the command could not be carried out; Ctrl-C."""
BROKEN = 1
"""Exit code of `improv doctor`: something does not work."""


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


class _Seconds(click.FloatRange):
    """How much to play, and not without end."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        seconds = float(super().convert(value, param, ctx))
        if math.isnan(seconds):  # neither below the least nor above the most
            self.fail(f"{value} is no number of seconds.", param, ctx)
        return seconds


_LENGTH = _Seconds(0, 1e12, min_open=True)


@improv.command()
@_files
@click.option("--format", "layout", type=click.Choice(["text", "json"]), default="text", help="How to tell it.")
def check(files: tuple[Path, ...], layout: str) -> None:
    """Say what is wrong with programs. Exit code 1 if any has errors."""

    def tell(path: Path, analysis: Analysis) -> None:
        if layout == "json":
            _print_json({"file": str(path), "ok": analysis.ok, "diagnostics": as_json(analysis)})
        else:
            for line in told(path, analysis):
                click.echo(line)

    _each(files, tell)


@improv.command("compile")
@_files
@click.option("--format", "layout", type=click.Choice(["json"]), default="json", help="JSON, a line for each file.")
@click.option("--max-segments", type=click.IntRange(min=1), default=10_000, show_default=True, help="For each robot.")
def compile_(files: tuple[Path, ...], layout: str, max_segments: int) -> None:
    """Print the velocities a program compiles to. Exit code 1 if any has errors."""
    from improv_core.program.compiler import compiled

    def tell(path: Path, analysis: Analysis) -> None:
        _print_json({"file": str(path), **compiled(analysis, max_segments), "diagnostics": as_json(analysis)})

    _each(files, tell)


@improv.command()
@_file
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="An .svg or .png file to write.")
@click.option("--timeline", is_flag=True, help="Show who does what when, too.")
def plot(file: Path, output: Path, timeline: bool) -> None:
    """Draw the ideal paths of a program's robots, without a browser. Exit code 1 if it has errors."""
    from improv_core.commands.plot import PlotError, plot_file

    try:
        sys.exit(plot_file(file, output, timeline=timeline))
    except (ReadError, PlotError) as problem:
        raise CannotError(str(problem)) from None


@improv.command("format")
@_files
@click.option("--check", is_flag=True, help="Write nothing; name the files that would change: exit code 1 if any.")
@click.option("--diff", is_flag=True, help="Write nothing; show what would change.")
def format_(files: tuple[Path, ...], check: bool, diff: bool) -> None:
    """Give programs their one layout: in files, in folders, and in the code blocks of Markdown files."""
    from improv_core.commands.format import format_files

    sys.exit(format_files(files, check=check, diff=diff))


BACKENDS = ["auto", "sim", "ros", "both"]
_backend = click.option(
    "--backend",
    type=click.Choice(BACKENDS),
    default="auto",
    show_default=True,
    help="The simulator, ROS 2, or both; auto takes ROS 2 where it can be had.",
)
_port = click.option("--port", type=click.IntRange(0, 65535), default=0, help="The page's port; 0 takes a free one.")
_browser = click.option("--no-browser", is_flag=True, help="Do not open the simulator's page.")


@improv.command()
@_file
@_backend
@_port
@_browser
@click.option("--fast", is_flag=True, help="In the simulator, without its page, as fast as it can be computed.")
@click.option("--for", "seconds", type=_LENGTH, help="Seconds at most, with --fast.")
@click.option("--report", type=click.Choice(["json"]), help="End with a line that says where the robots are.")
def play(
    file: Path, backend: str, port: int, no_browser: bool, fast: bool, seconds: float | None, report: str | None
) -> None:
    """Play a program once. Ctrl-C stops the robots."""
    if seconds and not fast:
        raise CannotError("--for goes with --fast: end what is played with Ctrl-C")
    if fast and backend in ("ros", "both"):
        raise CannotError("--fast is for the simulator: robots can't be hurried")
    if fast:
        _rehearse(file, seconds, report=report is not None)
    from improv_core.commands import terminal

    _run(terminal.play(file, _options(backend, port), browser=not no_browser, report=report is not None))


@improv.command()
@_file
@_backend
@_port
@_browser
def watch(file: Path, backend: str, port: int, no_browser: bool) -> None:
    """Play a program, and again at every save, for editors without a language server."""
    from improv_core.commands import terminal

    _run(terminal.watch(file, _options(backend, port), browser=not no_browser))


@improv.command()
@_file
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="The MCAP file to write.")
@click.option("--for", "seconds", type=_LENGTH, help="Seconds at most.")
@click.option("--backend", type=click.Choice(BACKENDS), help="Play it now, and record that.")
@_port
@_browser
def record(file: Path, output: Path, seconds: float | None, backend: str | None, port: int, no_browser: bool) -> None:
    """Record what robots are told, for `ros2 bag play` and Foxglove."""
    from improv_core.commands import record as recording

    try:
        if not backend:
            sys.exit(recording.record(file, output, seconds))
        if seconds:
            raise CannotError("--for goes without --backend: end what is played with Ctrl-C")
        _run(recording.record_live(file, output, _options(backend, port), browser=not no_browser))
    except (ReadError, recording.RecordError) as problem:
        raise CannotError(str(problem)) from None


@improv.command()
@click.argument("file", required=False, type=click.Path(path_type=Path))
def doctor(file: Path | None) -> None:
    """Say what is there to play with, and what to do about what is not. Exit code 1 if something is broken."""
    from improv_core.commands.doctor import Mark, examine

    marks = set()
    for finding in examine(file):
        click.echo(finding)
        marks.add(finding.mark)
    sys.exit(BROKEN if Mark.BROKEN in marks else 0)


@improv.group()
def ros() -> None:
    """ROS 2, where there is none of your own."""


@ros.command()
def setup() -> None:
    """Get ROS 2's Python packages, and prove that they work."""
    from improv_core.commands.ros_setup import SetupError, set_up

    try:
        set_up(click.echo)
    except SetupError as problem:
        raise CannotError(str(problem)) from None
    except KeyboardInterrupt:
        CannotError("interrupted: run `improv ros setup` again").show()
        sys.exit(INTERRUPTED)


def _rehearse(file: Path, seconds: float | None, *, report: bool) -> None:
    from improv_core.commands.rehearsal import rehearse

    try:
        sys.exit(rehearse(file, seconds, report=report))
    except ReadError as problem:
        raise CannotError(str(problem)) from None


def _options(backend: str, port: int) -> Options:
    from improv_core.playback.playback import Options

    return Options(backend, port)


def _run(command: Coroutine[Any, Any, int]) -> None:
    import asyncio

    from improv_core.playback.stage_process import StageError

    try:
        sys.exit(asyncio.run(command))
    except (ReadError, StageError) as problem:
        raise CannotError(str(problem)) from None


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
            analysis = analyze_file(path)
        except ReadError as problem:
            CannotError(str(problem)).show()
            code = CANNOT
        else:
            tell(path, analysis)
            code = max(code, 0 if analysis.ok else WRONG_PROGRAM)
    sys.exit(code)


def _print_json(value: Any) -> None:
    click.echo(json.dumps(value, ensure_ascii=False))
