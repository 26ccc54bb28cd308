"""Exit codes of `improv`, and the error that ends a command in one line."""

from __future__ import annotations

from typing import IO, Any

import click

from improv_core.commands.echo import echo

PROBLEMS = 1
"""The command did its work and found problems: in a program, in formatting, or on this machine."""
FAILED = 2
"""The command could not do its work; click uses it too, for wrong options."""
INTERRUPTED = 130
"""Interrupted by Ctrl-C, as shells report it. `improv` ends with 0 instead if `ros2 launch` has started it."""
MEANINGS = {
    0: "success",
    PROBLEMS: "errors or findings: in a program, in formatting, or on this machine",
    FAILED: "the command can't do its work: a missing file, a wrong option, no robot, a fault",
    INTERRUPTED: "interrupted or stopped by somebody",
}
"""Meaning of each exit code, for `improv --help` and docs/command-line.md."""


class CommandError(click.ClickException):
    """The command could not do its work; one plain line that says why."""

    exit_code = FAILED

    def show(self, file: IO[Any] | None = None) -> None:
        echo(f"improv: {self.message}", err=True)
