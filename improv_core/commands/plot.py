"""`improv plot`: the picture of a program in a file (resvg, imported lazily, makes PNG of SVG)."""

from __future__ import annotations

from pathlib import Path

import click

from improv_core.program.compiler import score_of
from improv_core.program.files import analyze_file
from improv_core.program.report import told
from improv_core.score.svg import plot

WRONG_PROGRAM = 1
FINENESS = 2
"""Pixels of a PNG for each of the SVG's, so that it is sharp on a projector."""


class PlotError(Exception):
    """The picture can't be written; one plain line that says why."""


def plot_file(path: Path, output: Path, *, timeline: bool) -> int:
    """Draw a program into an .svg or .png file; the exit code. Raises ReadError and PlotError."""
    if output.suffix not in (".svg", ".png"):
        raise PlotError(f"{output}: a picture's name ends in .svg or .png")
    analysis = analyze_file(path)
    for line in told(path, analysis):
        click.echo(line, err=True)
    if not analysis.ok:
        return WRONG_PROGRAM
    picture = plot(score_of(analysis), timeline)
    try:
        output.write_bytes(picture.encode() if output.suffix == ".svg" else _png(picture))
    except OSError as error:
        raise PlotError(f"{output}: {(error.strerror or 'it can not be written').lower()}") from None
    return 0


def _png(picture: str) -> bytes:
    import resvg_py

    return bytes(resvg_py.svg_to_bytes(svg_string=picture, background="white", zoom=FINENESS))
