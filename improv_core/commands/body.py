"""`improv body`: proposes the sections of an `improv.toml` for a robot's body from its URDF."""

from __future__ import annotations

import json
from pathlib import Path

import click

from improv_core.commands.echo import echo_text
from improv_core.commands.exit_codes import CommandError
from improv_core.commands.xacro import expand, find_xacro, is_xacro
from improv_core.ipc.child import output
from improv_core.outputs.ros.discovery import limited
from improv_core.outputs.ros.setup.interpreter import SETUP, find_ros_python
from improv_core.plain import printable
from improv_core.program.files import STANDARD_INPUT, read_bytes
from improv_core.protocol.limits import FOLDER
from improv_core.robots.urdf import LARGEST_URDF, UrdfError, read_urdf
from improv_core.robots.urdf_sections import sections


@click.command("body")
@click.argument("file", required=False, type=click.Path(path_type=Path))
@click.option("--topic", metavar="TOPIC", help="Read the URDF that ROS 2 publishes there, such as /robot_description.")
@click.option("--profile", metavar="NAME", help="The profile's name. Without it, the URDF's name of the robot.")
@click.option(
    "--part",
    "parts",
    metavar="NAME=LINK",
    multiple=True,
    help="A body part, and the link at its end. Without any, the parts are what people would name.",
)
def command(file: Path | None, topic: str | None, profile: str | None, parts: tuple[str, ...]) -> None:
    """Print the sections of improv.toml for a robot's body, from its URDF.

    FILE is a URDF, or a xacro file if the program `xacro` is installed. Check the output before you add it to
    improv.toml: a URDF doesn't say which direction of a part a joint is, so each is a proposal.
    """
    tips = dict(map(_tip, parts))
    if topic and not file:
        source, read = topic, _published(topic)
    elif file and not topic:
        source, read = str(file), read_bytes(file, LARGEST_URDF)
        if is_xacro(read) and file != STANDARD_INPUT and (program := find_xacro()):
            source, read, file = f"{file}, expanded by xacro", expand(program, file), None
    else:
        raise click.UsageError("name either a file or a --topic")
    try:
        again = str(file) if file and file != STANDARD_INPUT else None
        echo_text(sections(read_urdf(read), printable(source), profile, tips, again))
    except UrdfError as error:
        raise CommandError(f"{source}{f':{error.line}' if error.line else ''}: {error}") from None


def _tip(part: str) -> tuple[str, str]:
    name, equals, link = part.partition("=")
    if not (name and equals and link):
        raise click.UsageError(f"write --part NAME=LINK, such as --part head=head_link, not {part!r}")
    return name, link


LIMIT = 30.0
"""Seconds until ROS 2 must have answered on a busy machine; a node looks for the topic's publisher for 3 s."""


def _published(topic: str) -> bytes:
    """Return the URDF that ROS 2 publishes on a topic. Raises CommandError and InterpreterError."""
    if not (found := find_ros_python(None)):
        raise CommandError(f"there is no ROS 2 to read {topic} with: {SETUP} installs it")
    try:
        said = json.loads(
            output([found.python, str(FOLDER), "outputs.ros.graph", "text", topic], LIMIT, limited(found.env))
        )
    except OSError:
        raise CommandError("ROS 2 does not start: `improv doctor` says why") from None
    if said is None:
        raise CommandError(f"nobody publishes text on {topic}: start robot_state_publisher, or name another topic")
    return str(said).encode()
