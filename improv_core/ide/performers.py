"""Which robots perform a statement: those of its own line, or those of the lines that play what it defines."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain, islice

from improv_core.program.analysis import Analysis
from improv_core.robots.config import Robots
from improv_core.score.profiles import DEFAULT, Profile

MOST_ROBOTS, MOST_USERS = 100, 1_000
"""Robots, and statements that use a definition, that are looked at."""


def performers(analysis: Analysis, index: int) -> dict[Profile, str]:
    """The profiles of the robots that play a statement, or of all robots if none does, and the first robot of each."""
    return by_profile(analysis.cast, dict.fromkeys(chain.from_iterable(_players(analysis, index))))


def by_profile(cast: Robots, robots: Iterable[str]) -> dict[Profile, str]:
    """The profiles of these robots, or of all listed ones if there are none, and the first robot of each."""
    found: dict[Profile, str] = {}
    for robot in islice(tuple(robots) or cast.robots, MOST_ROBOTS):
        found.setdefault(cast.robot(robot).profile, robot)
    return found or {DEFAULT: ""}


def _players(analysis: Analysis, index: int) -> Iterator[Sequence[str]]:
    """The robots of each line that plays a statement, itself or by the names that are defined with it."""
    reached, waiting = {index}, [index]
    while waiting:
        index = waiting.pop(0)
        if robots := analysis.meanings[index].robots:
            yield robots
        name = analysis.statements[index].defines
        following = analysis.bindings.users(name, index)[:MOST_USERS] if name else ()
        waiting += [each for each in following if each not in reached and len(reached) < MOST_USERS]
        reached.update(waiting)
