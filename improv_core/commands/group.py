"""A group of commands whose list shows whole sentences, where click cuts them off."""

from __future__ import annotations

import click

LONGEST_SENTENCE = 1_000


class Group(click.Group):
    """Lists each command with the whole first sentence of its help."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        commands = {name: self.get_command(ctx, name) for name in self.list_commands(ctx)}
        with formatter.section("Commands"):
            formatter.write_dl(
                [(name, each.get_short_help_str(LONGEST_SENTENCE)) for name, each in commands.items() if each]
            )
