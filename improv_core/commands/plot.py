"""`improv plot`: the paths of a program's robots as a picture (resvg, imported lazily, turns SVG into PNG)."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.exit_codes import PROBLEMS, CommandError
from improv_core.commands.programs import read_to_play
from improv_core.program.compiler import score_of
from improv_core.program.room import prediction_of
from improv_core.score.meetings import check_room
from improv_core.score.svg import plot
from improv_core.stage.dry_run import predict
from improv_core.storage.atomic_write import replacing, why

PIXELS = 2
"""Pixels of a PNG for each pixel of the SVG, so that it is sharp on a projector."""


@click.command("plot")
@parameters.file
@click.option("-o", "--output", required=True, type=click.Path(path_type=Path), help="The .svg or .png file to write.")
@click.option("--timeline", is_flag=True, help="Also draw a timeline of what each robot does.")
def command(file: Path, output: Path, timeline: bool) -> None:
    """Draw the ideal paths of a program's robots. Exit code 1 if the program has errors.

    The picture shows them from above and, if a robot climbs, also from the side. Where robots would meet, it shows
    both. Below are charts of the joints that move, with their limits. FILE is a program, or - for standard input.
    """
    if (ending := output.suffix.lower()) not in (".svg", ".png"):
        raise CommandError(f"{output}: the picture's name must end in .svg or .png")
    if not (analysis := read_to_play(file)):
        sys.exit(PROBLEMS)
    score = score_of(analysis)
    prediction = prediction_of(analysis, score, predict)
    meetings = check_room(prediction.score if prediction else score).meetings
    picture = plot(score, timeline, meetings=meetings, prediction=prediction)
    try:
        with replacing(output) as target:
            target.write(picture.encode() if ending == ".svg" else _png(picture))
    except OSError as error:
        raise CommandError(f"{output}: {why(error)}") from None


def _png(picture: str) -> bytes:
    import resvg_py

    return bytes(resvg_py.svg_to_bytes(svg_string=picture, zoom=PIXELS))
