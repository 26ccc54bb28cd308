"""The `improv` command line: one module for each command, imported when that command is used."""

from __future__ import annotations

import io
import os
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import click

from improv_core import LineError, __version__
from improv_core.commands.echo import echo, printable_usage_errors
from improv_core.commands.exit_codes import FAILED, INTERRUPTED, MEANINGS, CommandError
from improv_core.commands.group import Group
from improv_core.commands.ros_arguments import is_launched, without_ros_arguments

COMMANDS = {
    "edit": ("edit", "Write a program on the page in the browser."),
    "new": ("new", "Make a small program to start from."),
    "check": ("check", "Check programs for errors, and whether robots meet or hit something."),
    "compile": ("compile", "Print the velocities that programs compile to."),
    "plot": ("plot", "Draw the ideal paths of a program's robots."),
    "format": ("format", "Format programs."),
    "transcribe": ("transcribe", "Write the program for paths that were recorded or drawn."),
    "merge": ("merge", "Merge programs into one, in which all play side by side."),
    "play": ("play", "Play a program."),
    "watch": ("watch", "Play a program every time it is saved."),
    "stop": ("stop", "Stop all robots that your terminals and editors move."),
    "record": ("record", "Record the commands that robots get, for `ros2 bag play` and Foxglove."),
    "history": ("history", "List the programs that played; with N, print one of them."),
    "place": ("place", "Drive real robots slowly to where a program has them."),
    "calibrate": ("calibrate", "Measure how far a robot really drives and turns, and correct its profile."),
    "body": ("body", "Print the sections of improv.toml for a robot's body, from its URDF."),
    "site": ("site", "Build a website in FOLDER, on which people write programs and play them in the simulator."),
    "class": ("class_room", "Let a class write dances on tablets, and play them in the simulator."),
    "doctor": ("doctor", "Check what works here, and which robots listen."),
    "output": ("output", "Check an output for robots."),
    "hosts": ("hosts", "Allow Improv to use other machines, with your ssh keys, and robots' addresses."),
    "ros": ("ros_setup", "Set up ROS 2 on a machine without it."),
}
"""Commands in the order of `improv --help`: the module of each, which holds it as `command`, and the first sentence of
its help."""


def main() -> None:
    """Run the `improv` command."""
    # The beat counter and the names of robots need more than some terminals' own encoding.
    if isinstance(sys.stderr, io.TextIOWrapper):
        sys.stderr.reconfigure(encoding="utf-8", errors="replace")
    stream = sys.stdout or Path(os.devnull).open("w")  # noqa: SIM115 (it is None if a shell has closed it)
    output = sys.stdout = Output(stream.buffer, "utf-8", "replace", line_buffering=stream.isatty())
    try:
        ours, theirs = without_ros_arguments(sys.argv[1:])
        improv(ours, obj=theirs)
    except (SystemExit, OSError) as end:
        if not output.problem:
            if isinstance(end, SystemExit) and isinstance(end.__context__, KeyboardInterrupt):
                output.flush()
                os._exit(int(end.code or 0))  # Python would exit with -2 if it made a dataclass when the signal came
            raise
        if not isinstance(output.problem, BrokenPipeError):  # `improv … | head` is no error
            CommandError(f"cannot write to standard output: {str(output.problem.strerror).lower()}").show()
        # Otherwise Python tries to write the rest at exit, and prints a traceback.
        os.dup2(os.open(os.devnull, os.O_WRONLY), output.fileno())
        sys.exit(FAILED)


class Output(io.TextIOWrapper):
    """Standard output that remembers its first failure, because a later write may succeed."""

    problem: OSError | None = None

    def write(self, text: str) -> int:
        try:
            return super().write(text)
        except OSError as problem:
            self.problem = problem
            raise

    def flush(self) -> None:
        try:
            super().flush()
        except OSError as problem:
            self.problem = problem
            raise


WIDEST_HELP = 100
"""Columns of help texts in a terminal that has more."""


class Commands(Group):
    """Imports only the command that is used, also for help and completion: `improv stop` must start fast.

    Errors for people, problems of files, and interrupts end in one line.
    """

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return the command as a list shows it."""
        return click.Command(cmd_name, short_help=COMMANDS[cmd_name][1]) if cmd_name in COMMANDS else None

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name, found, rest = super().resolve_command(ctx, args)
        if found and name:
            found = import_module(f"improv_core.commands.{COMMANDS[name][0]}").command
        return name, found, rest

    def advice(self, ctx: click.Context, name: str) -> str | None:
        return f"did you mean `improv play {name}`?" if Path(name).is_file() else super().advice(ctx, name)

    def make_context(self, *arguments: Any, **named: Any) -> click.Context:
        with printable_usage_errors():
            return super().make_context(*arguments, **named)

    def invoke(self, ctx: click.Context) -> Any:
        try:
            with printable_usage_errors():
                return super().invoke(ctx)
        except OSError as problem:
            if problem.filename is None:  # `main` says that the output can't be written
                raise
            raise CommandError(f"{problem.filename}: {(problem.strerror or 'it cannot be used').lower()}") from None
        except (KeyboardInterrupt, SystemExit) as end:
            if isinstance(end, KeyboardInterrupt):
                echo("improv: interrupted", err=True)
            elif end.code != INTERRUPTED:
                raise
            sys.exit(0 if is_launched() else INTERRUPTED)  # to `ros2 launch`, a node with another code has died
        except LineError as problem:
            raise CommandError(str(problem)) from None

    def format_epilog(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Exit codes"):
            formatter.write_dl([(str(code), meaning) for code, meaning in MEANINGS.items()])


@click.group(cls=Commands, context_settings={"help_option_names": ["-h", "--help"], "max_content_width": WIDEST_HELP})
@click.version_option(__version__, prog_name="improv")
def improv() -> None:
    """Live coding for robot motion: write a few words of choreography, and robots move."""
