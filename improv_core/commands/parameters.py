"""Arguments and options that several commands share."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from improv_core.session.start import Options


class _FileName(click.Path):
    """A name that is not empty: as a path, `""` would be this folder."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        if value == "":
            self.fail("it is empty.", param, ctx)
        return super().convert(value, param, ctx)


files = click.argument("files", nargs=-1, required=True, type=_FileName(path_type=Path))
file = click.argument("file", type=_FileName(path_type=Path))

RECORDING = click.Path(path_type=Path)
BACKENDS = click.Choice(["auto", "sim", "ros", "both"])
port = click.option(
    "--port",
    type=click.IntRange(0, 65535),
    metavar="PORT",
    default=0,
    help="Port of the simulator's page; 0 picks a free one.",
)
no_browser = click.option("--no-browser", is_flag=True, help="Do not open the simulator's page in a browser.")
continues = click.option(
    "--continue",
    "when",
    flag_value="beat",
    default="restart",
    help="Robots whose part a save doesn't change keep dancing.",
)
at_bar = click.option(
    "--continue-at-bar", "when", flag_value="bar", help="The same, and a save takes effect at the next bar."
)
force = click.option("--force", is_flag=True, help="Begin even if robots are not in their places.")
osc_network = click.option(
    "--osc-network", is_flag=True, help="Exchange OSC messages also with other machines, as improv.toml says."
)
backend = click.option(
    "--backend",
    type=BACKENDS,
    default="auto",
    show_default=True,
    help="Play in the simulator, on ROS 2, or on both; auto uses ROS 2 if it is available.",
)


@dataclass(frozen=True, slots=True)
class LiveOptions:
    """Options of a live performance: the backend that plays, the port of its page, whether a browser shows it, and
    whether OSC messages reach other machines."""

    backend: str
    port: int
    browser: bool
    osc_network: bool = False

    def options(self, file: Path) -> Options:
        """Return the options for playing a program, with the arguments after `--ros-args`."""
        from improv_core.outputs.ros.setup.interpreter import find_ros_python
        from improv_core.program.files import ReadError, robots_near
        from improv_core.session.start import Options

        node = None
        with suppress(ReadError):  # an error about the program itself comes when it is read
            node = robots_near(file.absolute().parent).node
        return Options(
            self.backend,
            self.port,
            find_python=find_ros_python,
            node=node,
            ros_arguments=click.get_current_context().obj or (),
            osc="network" if self.osc_network else "here",
        )


def live(command: Callable[..., None]) -> Callable[..., None]:
    """Add `--backend`, `--port`, and `--no-browser` to a command, which gets their values as `live`; also the value of
    `--osc-network`, if the command has that option."""

    @backend
    @port
    @no_browser
    @wraps(command)
    def with_live(
        *given: Any, backend: str, port: int, no_browser: bool, osc_network: bool = False, **others: Any
    ) -> None:
        command(*given, live=LiveOptions(backend, port, not no_browser, osc_network), **others)

    return with_live


class InRange(click.FloatRange):
    """A number in a range, which NaN isn't."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        number: float = super().convert(value, param, ctx)
        return self.fail(f"{value!r} is no number.", param, ctx) if math.isnan(number) else number


SECONDS = InRange(0, 1e12, min_open=True)
"""A duration."""
