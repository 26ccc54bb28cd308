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
"""Ctrl-C, as shells report it."""


class CommandError(click.ClickException):
    """The command could not do its work; one plain line that says why."""

    exit_code = FAILED

    def show(self, file: IO[Any] | None = None) -> None:
        echo(f"improv: {self.message}", err=True)
