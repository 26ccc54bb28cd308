"""`improv history`: the programs that played."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from improv_core.commands import parameters
from improv_core.commands.echo import echo, echo_text
from improv_core.commands.exit_codes import PROBLEMS, CommandError
from improv_core.commands.group import Group
from improv_core.commands.parameters import LiveOptions
from improv_core.commands.playing import play
from improv_core.commands.programs import report_diagnostics
from improv_core.commands.terminal import run
from improv_core.program.analysis import analyze
from improv_core.program.files import robots_near
from improv_core.robots.config import Robots
from improv_core.storage.history import Played, read

WIDTH = 60
"""Characters that the list shows of a line."""


class HistoryGroup(Group):
    """A group in which a number is a command as well: it prints that program."""

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name.isdecimal():
            return click.Command(cmd_name, callback=lambda: echo_text(_program(int(cmd_name)).text))
        return super().get_command(ctx, cmd_name)


@click.group("history", cls=HistoryGroup, invoke_without_command=True, subcommand_metavar="[N | COMMAND [ARGS]...]")
@click.pass_context
def command(ctx: click.Context) -> None:
    """List the programs that played; with N, print one of them. The latest is number 1."""
    if ctx.invoked_subcommand:
        return
    history = read()
    for number, each in reversed(list(enumerate(history.programs, 1))):
        echo(f"{number:>3}  {each.when}  {each.name}  {history.news(each)[:WIDTH]}")
    if history.complaint:
        echo(f"improv: {history.complaint}", err=True)
    elif not history.programs:
        echo("nothing has played yet")


@command.command("play")
@click.argument("number", metavar="N", type=click.IntRange(min=1))
@parameters.live
def play_again(number: int, live: LiveOptions) -> None:
    """Play a program from the history once. Ctrl-C stops the robots."""
    program = _program(number)
    path = Path(program.file)
    if path.is_absolute() and not path.parent.is_dir():
        raise CommandError(
            f"{path.parent} is gone, and so is the improv.toml that described its robots: "
            f"save the program elsewhere with `improv history {number} > dance.improv`, then play that"
        )
    analysis = analyze(program.text, robots_near(path.parent) if path.is_absolute() else Robots())
    report_diagnostics(path, analysis)
    if not analysis.ok:
        sys.exit(PROBLEMS)
    sys.exit(run(play(analysis, path, live.options(path), browser=live.browser)))


def _program(number: int) -> Played:
    """Return the program with this number in the list. Raises CommandError."""
    programs = read().programs
    if not 1 <= number <= len(programs):
        raise CommandError(f"the history has no program {number}: `improv history` lists what it has")
    return programs[number - 1]
