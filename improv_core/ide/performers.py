"""Find the robots that perform a statement: those of its own line, or those of the lines that play its definition."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain, islice

from improv_core.ide.references import lines_playing
from improv_core.program.analysis import Analysis
from improv_core.robots.config import Robots
from improv_core.score.profiles import DEFAULT, Profile

MOST_ROBOTS = 100
"""The most robots that are searched."""


def performers(analysis: Analysis, index: int) -> dict[Profile, str]:
    """Return the profiles of the robots that play a statement, or of all robots if none does, each with its first
    robot."""
    lines = (analysis.meanings[line].robots for line in lines_playing(analysis, index))
    return by_profile(analysis.opening.config, dict.fromkeys(chain.from_iterable(lines)))


def by_profile(config: Robots, robots: Iterable[str]) -> dict[Profile, str]:
    """Return the profiles of these robots, or of all listed ones if there are none, and the first robot of each."""
    found: dict[Profile, str] = {}
    for robot in islice(tuple(robots) or config.robots, MOST_ROBOTS):
        found.setdefault(config.robot(robot).profile, robot)
    return found or {DEFAULT: ""}
