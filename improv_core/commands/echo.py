"""The output of commands: text through `echo`, data through `echo_json`. None of it can steer a terminal."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click

from improv_core.plain import printable


def echo(line: str, *, err: bool = False, color: str | None = None) -> None:
    """Print one line; quoted text stays in that line. Colors only show on a terminal, and not with NO_COLOR."""
    plain = color is None or "NO_COLOR" in os.environ
    click.echo(printable(line) if plain else click.style(printable(line), fg=color), err=err)


def echo_text(text: str) -> None:
    """Print a text: in a terminal as printable lines, elsewhere exactly."""
    if sys.stdout.isatty():
        for line in text.splitlines():
            echo(line)
    else:
        click.echo(text, nl=False)


def echo_json(value: Any) -> None:
    """Print one line of JSON: ASCII, since JSON itself allows characters that steer terminals."""
    click.echo(json.dumps(value))


@contextmanager
def printable_usage_errors() -> Iterator[None]:
    """Make errors of click printable, because they quote arguments: a shell's `*` expands to names of any kind."""
    try:
        yield
    except click.UsageError as error:
        raise click.UsageError(printable(error.format_message()), error.ctx) from None
