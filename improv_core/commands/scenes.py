"""Options that play only some scenes of a program."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Any

import click

from improv_core.commands.exit_codes import CommandError
from improv_core.ide.rehearsal import rehearse, scenes_named
from improv_core.ide.selection import Selection, UnplayableError
from improv_core.program.analysis import Analysis


@dataclass(frozen=True, slots=True)
class WantedScenes:
    """Scenes from one to another, by name or by number, counted from 1. None stands for the first or the last one."""

    first: str | int | None = None
    last: str | int | None = None

    def of(self, analysis: Analysis) -> Selection:
        """Select these scenes of a program; all of it if no option names any. Raises UnplayableError."""
        if self.first is None and self.last is None:
            return Selection("", analysis)
        return rehearse(analysis, scenes_named(analysis, self.first, self.last))


def options(command: Callable[..., None]) -> Callable[..., None]:
    """Add `--from`, `--to`, and `--only` to a command, which gets their values as `wanted`."""

    @wraps(command)
    def with_scenes(*given: Any, first: str | None, last: str | None, only: str | None, **others: Any) -> None:
        if only is not None and (first is not None or last is not None):
            raise CommandError("--only plays one scene: leave out --from and --to")
        command(*given, wanted=WantedScenes(first, last) if only is None else WantedScenes(only, only), **others)

    with_options: Callable[..., None] = with_scenes
    for name, parameter, about in (
        ("--only", "only", "Play only the scene with this name."),
        ("--to", "last", "End after the scene with this name."),
        ("--from", "first", "Begin with the scene of this name, with robots where they are then."),
    ):
        with_options = click.option(name, parameter, metavar="NAME", help=about)(with_options)
    return with_options


def chosen(analysis: Analysis, scenes: WantedScenes) -> Selection:
    """Select these scenes of a program. Raises CommandError if it lacks them."""
    try:
        return scenes.of(analysis)
    except UnplayableError as error:
        raise CommandError(str(error)) from None
