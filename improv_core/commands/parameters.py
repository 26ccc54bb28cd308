"""Arguments and options that several commands share."""

from __future__ import annotations

import math
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from improv_core.playback.start import Options

files = click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
file = click.argument("file", type=click.Path(path_type=Path))

RECORDING = click.Path(path_type=Path)
BACKENDS = click.Choice(["auto", "sim", "ros", "both"])
port = click.option(
    "--port", type=click.IntRange(0, 65535), default=0, help="Port of the simulator's page; 0 picks a free one."
)
no_browser = click.option("--no-browser", is_flag=True, help="Do not open the simulator's page in a browser.")
continues = click.option(
    "--continue",
    "when",
    flag_value="beat",
    default="restart",
    help="Robots whose part a save does not change dance on, untouched.",
)
backend = click.option(
    "--backend",
    type=BACKENDS,
    default="auto",
    show_default=True,
    help="Play in the simulator, on ROS 2, or on both; auto uses ROS 2 if it is available.",
)


def options(file: Path, backend: str, port: int) -> Options:
    """What to play a program on, with the arguments after `--ros-args`."""
    from improv_core.playback.start import Options  # here, since only some commands need it
    from improv_core.program.files import ReadError, robots_near

    node = None
    with suppress(ReadError):  # which is reported when the program is read
        node = robots_near(file.absolute().parent).node
    return Options(backend, port, node=node, ros_arguments=click.get_current_context().obj or ())


class _Seconds(click.FloatRange):
    """A positive, finite duration."""

    name = "seconds"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        seconds = float(super().convert(value, param, ctx))
        if math.isnan(seconds):  # which is within any range
            self.fail(f"{value} is not a number of seconds.", param, ctx)
        return seconds


SECONDS = _Seconds(0, 1e12, min_open=True)
