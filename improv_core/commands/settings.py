"""Settings with which a terminal plays programs, and the options of commands that set them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import wraps
from typing import TYPE_CHECKING, Any

import click

from improv_core.commands.exit_codes import CommandError

if TYPE_CHECKING:  # completion reads the options alone
    from improv_core.ide.selection import Selection
    from improv_core.program.analysis import Analysis
    from improv_core.protocol.messages import Arming, Sensed, When


@dataclass(frozen=True, slots=True)
class PlaySettings:
    """Settings for all programs that a terminal plays."""

    first: str | int | None = None
    """A scene, by name or by number, counted from 1; None stands for the first one."""
    last: str | int | None = None
    """A scene; None stands for the last one."""
    count_in: bool = False
    """True if a bar is counted before beat 0 although improv.toml doesn't ask for it."""
    bell: bool = False
    """True if the terminal's bell rings with the count."""
    when: When = "restart"
    """The time at which a save takes effect."""
    anyway: bool = False
    """True if robots may stand in other places than their own."""
    senses: Sequence[Sensed] | None = None
    """A recording: robots sense what is in it, and nothing else."""
    arming: Arming | None = None
    """The arming with which a program waits once everything is ready."""

    def chosen(self, analysis: Analysis) -> Selection:
        """Select the wanted scenes of a program; all of it if no option names any. Raises UnplayableError."""
        from improv_core.ide.rehearsal import rehearse, scenes_named
        from improv_core.ide.selection import Selection

        if self.first is None and self.last is None:
            return Selection("", analysis)
        return rehearse(analysis, scenes_named(analysis, self.first, self.last))


_OPTIONS = (
    click.option("--count-in", is_flag=True, help="Count one bar before the dance begins."),
    click.option("--bell", is_flag=True, help="Ring the terminal's bell with the count."),
    click.option(
        "--from",
        "first",
        metavar="NAME",
        help="Begin with the scene of this name, with robots where they are then.",
    ),
    click.option("--to", "last", metavar="NAME", help="End after the scene with this name."),
    click.option("--only", metavar="NAME", help="Play only the scene with this name."),
)


def options(command: Callable[..., None]) -> Callable[..., None]:
    """Add options about scenes and the count to a command, which gets its settings; also those of `--continue` and
    `--force`, if it has these options."""

    @wraps(command)
    def with_settings(
        *given: Any,
        count_in: bool,
        bell: bool,
        first: str | None,
        last: str | None,
        only: str | None,
        when: When = "restart",
        force: bool = False,
        **others: Any,
    ) -> None:
        if only is not None and (first is not None or last is not None):
            raise CommandError("--only plays one scene: leave out --from and --to")
        settings = PlaySettings(first, last, count_in, bell, when, force)
        command(*given, settings=settings if only is None else replace(settings, first=only, last=only), **others)

    with_options: Callable[..., None] = with_settings
    for option in reversed(_OPTIONS):
        with_options = option(with_options)
    return with_options
