"""Groups of commands whose help is not cut off, and that suggest a command for one that doesn't exist."""

from __future__ import annotations

from difflib import get_close_matches

import click

from improv_core.commands.echo import echo_text
from improv_core.commands.exit_codes import FAILED

LONGEST_SENTENCE = 1_000


class Group(click.Group):
    """Lists each command with the whole first sentence of its help, where click cuts it off."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        if not args and self.no_args_is_help and not ctx.resilient_parsing:
            echo_text(f"{ctx.get_help()}\n")
            ctx.exit(FAILED)
        return super().parse_args(ctx, args)

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        name = args[0]
        known = self.get_command(ctx, name) or name.startswith("-") or ctx.resilient_parsing
        if not known and (advice := self.advice(ctx, name)):
            ctx.fail(f"no such command {name!r}: {advice}")
        return super().resolve_command(ctx, args)

    def advice(self, ctx: click.Context, name: str) -> str | None:
        """Suggest the command that a person may have meant by one that doesn't exist."""
        near = get_close_matches(name, self.list_commands(ctx), 1)
        return f"did you mean `{ctx.command_path} {near[0]}`?" if near else None

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        commands = {name: self.get_command(ctx, name) for name in self.list_commands(ctx)}
        with formatter.section("Commands"):
            formatter.write_dl(
                [(name, each.get_short_help_str(LONGEST_SENTENCE)) for name, each in commands.items() if each]
            )
