"""`improv hosts`: the machines, serial ports, and addresses that Improv may use. Only a person allows one."""

from __future__ import annotations

import click

from improv_core.commands.echo import echo
from improv_core.commands.exit_codes import CommandError
from improv_core.commands.group import Group
from improv_core.safety.allowed import approve, approved, approved_file, withdraw
from improv_core.score.score import is_address


@click.group("hosts", cls=Group)
def command() -> None:
    """Allow Improv to use other machines, with your ssh keys, and robots' addresses."""


@command.command()
@click.argument("host")
def allow(host: str) -> None:
    """Allow Improv to use a host or an address that an `improv.toml` names."""
    approve(host)
    if is_address(host):
        echo(f"Improv may move robots at {host}.")
        return
    echo(f"Improv may start stages on {host}. Check it with `improv doctor --hosts`.")


@command.command("list")
def list_all() -> None:
    """List the hosts that Improv may use."""
    hosts = approved()
    for host in hosts:
        echo(host)
    if not hosts:
        line = "Improv may not use any other machine: allow one with `improv hosts allow HOST`"
        echo(f"{line} ({approved_file()} lists them)", err=True)


@command.command()
@click.argument("host")
def remove(host: str) -> None:
    """Remove a host from this list. Robots that play there keep playing until you stop them."""
    if not withdraw(host):
        raise CommandError(f"{host} was not allowed")
    echo(f"Improv may no longer use {host}.")
