"""`improv transcribe`: recorded or drawn paths → a program that performs them."""

from __future__ import annotations

import math
import os
import re
import signal
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from improv_core.commands.echo import echo, echo_text
from improv_core.commands.exit_codes import CommandError
from improv_core.commands.parameters import InRange
from improv_core.commands.programs import exists_already, write_new
from improv_core.program.files import robots_near
from improv_core.program.timing import decimal
from improv_core.robots.config import Robots
from improv_core.storage.atomic_write import why
from improv_core.syntax.vocabulary import UNITS, WORDS
from improv_core.transcription.reading import read_source
from improv_core.transcription.sources import Recording, robot_name
from improv_core.transcription.track import TimedPlace
from improv_core.transcription.transcribe import Tolerance, Transcription, transcribe

_LENGTH = re.compile(r"([0-9]*\.?[0-9]+)(m|cm|mm)")
_SLOW = 1.0
"""Seconds after which a line says that the search continues."""


class _Length(click.ParamType):  # type: ignore[type-arg]
    """A length above 0 with its unit, in meters."""

    name = "length"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        if isinstance(value, float):
            return value
        form = _LENGTH.fullmatch(str(value))
        if not form or not float(form[1]):
            self.fail(f"{value} is no length above 0: write 3cm, 5mm, or 0.1m", param, ctx)
        return float(form[1]) * float(UNITS[form[2]].size)


@click.command("transcribe")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--output", "-o", type=click.Path(path_type=Path), help="Write a new file; default: standard output.")
@click.option("--tolerance", type=_Length(), default="3cm", show_default=True, help="How far a path may be off.")
@click.option("--tempo", type=click.IntRange(1, 1000), help="Beats per minute; default: the likeliest.")
@click.option("--robot", help="Transcribe only this robot, or name the only one.")
@click.option("--seconds", type=InRange(0.1, 3600), default=20.0, show_default=True, help="A drawing's time, about.")
@click.option("--scale", type=InRange(1e-6, 1e6), help="Meters for each unit of a drawing; default: 4 m in all.")
def command(
    files: tuple[Path, ...],
    output: Path | None,
    tolerance: float,
    tempo: int | None,
    robot: str | None,
    seconds: float,
    scale: float | None,
) -> None:
    """Write the program for paths that were recorded or drawn.

    FILES are tables (.csv with columns for time, x, y, and perhaps heading and robot), recordings of ROS 2 (.mcap,
    .db3), or drawings (.svg). A path stays within the tolerance of what was recorded, 5 degrees, and 50 ms. Ctrl-C ends
    a long search with the best program so far.
    """
    if output and os.path.lexists(output):  # before a long search
        raise exists_already(output)
    recorded = _only(_recorded(files, seconds, scale), robot)
    robots = robots_near(output.absolute().parent if output else Path.cwd())
    made = _searched(recorded, robots, Tolerance(tolerance), tempo, output is not None)
    if output is None:
        echo_text(made.text)
        beat, other = made.tempo, 90 if made.tempo != 90 else 60
        keep = f"in a program with, say, `beat {other}`, put its words into `slow {other}/{beat} (…)`"
        echo(f"improv: its tempo is {beat}: {keep} to keep their speed", err=True)
    else:
        write_new(output, made.text)
    for name, (far, turned) in made.deviations.items():
        within = "" if far <= tolerance else f", more than {100 * tolerance:.2g} cm: allow more, or record more poses"
        echo(
            f"improv: {name} is at most {decimal(100 * far)} cm and {decimal(math.degrees(turned))}° off{within}",
            err=True,
        )


def _searched(
    recorded: Recording,
    robots: Robots,
    tolerance: Tolerance,
    tempo: int | None,
    is_whole: bool,
) -> Transcription:
    """Return the program that was found. Ctrl-C ends the search, and a second one the command."""
    ends = threading.Event()

    def end(*_: object) -> None:
        signal.signal(signal.SIGINT, before)
        ends.set()

    before = signal.signal(signal.SIGINT, end)
    waits = threading.Timer(_SLOW, lambda: echo("improv: still searching; Ctrl-C takes the best so far", err=True))
    waits.start()
    try:
        return transcribe(recorded.places, robots, tolerance, tempo, ends.is_set, is_whole, recorded.drawn)
    finally:
        waits.cancel()
        signal.signal(signal.SIGINT, before)


def _recorded(files: Sequence[Path], seconds: float, scale: float | None) -> Recording:
    """Return the places of all robots in files. What was guessed is printed."""
    found: dict[str, Sequence[TimedPlace]] = {}
    drawn: list[str] = []
    for path in files:
        try:
            source = read_source(path, seconds, scale)
        except OSError as error:
            raise CommandError(f"{path}: {why(error)}") from None
        for guess in source.guesses:
            echo(f"improv: {path.name}: {guess}", err=True)
        for name, places in source.places.items():
            robot = robot_name(name if name not in WORDS else f"{name}_robot", list(found))
            found[robot] = places
            drawn += [robot] if name in source.drawn else []
    return Recording(found, drawn=drawn)


def _only(recorded: Recording, robot: str | None) -> Recording:
    places, _, drawn = recorded
    if robot is None:
        return recorded
    found, name = robot, robot
    if robot not in places:
        if len(places) != 1:
            raise CommandError(f"no robot is named {robot}: there are {', '.join(places)}")
        (found,), name = places, robot_name(robot)
    return Recording({name: places[found]}, drawn=[name] if found in drawn else [])
