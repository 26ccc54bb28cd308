"""Words that need no definition in a program, but may have one: those for body parts, from profiles, and `to`."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache

from improv_core.program.reader import NOTHING, Definition, Takes
from improv_core.program.reporting import Items
from improv_core.robots.config import Robots
from improv_core.score.movement import NOWHERE

TO = "to"


def predefined(robots: Robots) -> Mapping[str, Definition]:
    """Return the definitions of these words, which apply if nothing above defines them."""
    return _predefined(robots.part_words)


@lru_cache(maxsize=100)
def _predefined(parts: frozenset[str]) -> Mapping[str, Definition]:
    return {TO: _word(TO, Takes.POSE), **{name: _word(name, Takes.MOVEMENT) for name in sorted(parts)}}


@lru_cache(maxsize=1_000)  # the same word has the same definition, so its uses keep their meanings
def _word(name: str, takes: Takes) -> Definition:
    return Definition(name, NOWHERE, NOTHING, Items((), NOWHERE), takes=takes)
