"""`improv output`: what Improv asks of an output for robots before anybody relies on it."""

from __future__ import annotations

import asyncio
from pathlib import Path

import click

from improv_core.commands.echo import echo
from improv_core.commands.exit_codes import PROBLEMS
from improv_core.commands.group import Group
from improv_core.commands.output_check import Row, checks
from improv_core.commands.output_subjects import Subject, subject_for
from improv_core.commands.parameters import InRange
from improv_core.program.files import robots_near

LIMIT = 0.6
"""Seconds within which a robot has to stand, whatever happens. Reports of a robot may be a tenth of one apart."""


@click.group("output", cls=Group)
def command() -> None:
    """Check an output for robots."""


@command.command()
@click.argument("name")
@click.option("--robot", help="The robot to move; default: the first one of this output in improv.toml.")
@click.option("--yes", "-y", is_flag=True, help="Don't ask before the robot moves.")
@click.option("--limit", type=InRange(0.1, 60), default=LIMIT, show_default=True, help="Seconds to a stop.")
def check(name: str, robot: str | None, yes: bool, limit: float) -> None:
    """Play, halt, kill, and unplug an output, and print whether its robot stops.

    NAME is the output of a robot in improv.toml, `ros`, or `simulator`. The last two move no real robot.
    """
    subject = subject_for(name, robot, robots_near(Path.cwd()))
    if subject.host and not yes:
        click.confirm(f"{subject.robot} will turn on the spot for half a minute. Is it on the floor?", abort=True)
    if not asyncio.run(_printed(subject, limit)):
        raise SystemExit(PROBLEMS)


async def _printed(subject: Subject, limit: float) -> bool:
    """Print a row for each check. Returns whether none has failed."""
    good = True
    async for row in checks(subject, limit):
        echo(line(row))
        good = good and row.passed is not False
    return good


def line(row: Row) -> str:
    """Return a row of the table."""
    return f"{row.check:22} {'-' if row.passed is None else 'yes' if row.passed else 'NO':4} {row.found}".rstrip()
