"""Options that count a bar before beat 0, so that people and robots start together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import wraps
from typing import Any

import click

from improv_core.score.score import Score


@dataclass(frozen=True, slots=True)
class CountIn:
    """Settings of the command line: count a bar before beat 0 although improv.toml doesn't ask for it, and ring the
    terminal's `bell` with the count."""

    wanted: bool = False
    bell: bool = False

    def of(self, score: Score) -> Score:
        """Return the score, counted in if that is wanted."""
        return replace(score, count_in=True) if self.wanted else score


def options(command: Callable[..., None]) -> Callable[..., None]:
    """Add `--count-in` and `--bell` to a command, which gets their values as `count_in`."""

    @click.option("--count-in", "wanted_count", is_flag=True, help="Count one bar before the dance begins.")
    @click.option("--bell", is_flag=True, help="Ring the terminal's bell with the count.")
    @wraps(command)
    def with_count(*given: Any, wanted_count: bool, bell: bool, **others: Any) -> None:
        command(*given, count_in=CountIn(wanted_count, bell), **others)

    return with_count
