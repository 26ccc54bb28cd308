"""`improv stop`: stops all of this user's performances, in any terminal or editor."""

from __future__ import annotations

import sys

import click

from improv_core.commands.echo import echo
from improv_core.commands.exit_codes import PROBLEMS, CommandError
from improv_core.safety.stop_socket import IDLE, StopSocketError, stop_all


@click.command("stop")
def command() -> None:
    """Stop all robots that your terminals and editors move."""
    stopped, all_answered = False, True
    try:
        for answer in stop_all():
            if answer != IDLE:
                stopped = True
                all_answered = all_answered and answer.startswith("stopped")
                echo(answer)
    except StopSocketError as problem:
        raise CommandError(f"`improv stop` does not work here: {problem}") from None
    if not stopped:
        echo("nothing is playing, and no command that is still starting will play")
    if not all_answered:
        sys.exit(PROBLEMS)
