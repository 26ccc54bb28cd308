"""`improv ros setup`: ROS 2's Python packages, on this machine or on the computer of a robot."""

from __future__ import annotations

import os
import sys

import click

from improv_core.commands.echo import echo
from improv_core.commands.exit_codes import INTERRUPTED, CommandError
from improv_core.commands.group import Group
from improv_core.hosts.connect import ConnectError
from improv_core.hosts.probe import set_up_there
from improv_core.outputs.ros.setup import setup as ros_setup
from improv_core.outputs.ros.setup.environment import AGAIN, Say
from improv_core.outputs.ros.setup.proof import Proof
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.score_json import to_json


@click.group("ros", cls=Group)
def command() -> None:
    """Set up ROS 2 on a machine without it."""


@command.command()
@click.option("--host", metavar="HOST", help="Do it on this machine, which `improv hosts allow` has to allow.")
def setup(host: str | None) -> None:
    """Install ROS 2's Python packages and test them."""
    try:
        if host:
            set_up_there(host, proof(), echo)
        else:
            set_up(echo)
    except ConnectError as error:
        raise CommandError(f"{host}: {error}") from None
    except KeyboardInterrupt:
        CommandError(f"interrupted: {AGAIN}").show()
        sys.exit(INTERRUPTED)


def set_up(say: Say) -> None:
    """Install and test ROS 2 on this machine. Raises SetupError."""
    ros_setup.set_up(say, proof())


def proof() -> Proof:
    """Prove that ROS 2 works: one robot goes forward."""
    robot = f"improv_setup_{os.getpid()}"  # not the name of any robot, so that none moves
    score = score_of(analyze(f"{robot} $ forward\n"))
    return Proof(score.parts[robot].topic, to_json(score))
