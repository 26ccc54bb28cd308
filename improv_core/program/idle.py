"""Finds lines that do nothing because of others: those that begin scenes without robots, and those below what never
ends."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from improv_core.program.program import Program, never_ends


class Idle(NamedTuple):
    """Why a line does nothing: the `scene` with this number or the `line` with this index, which is above, never ends.

    A line keeps these `robots` from this one. With neither, nothing plays in the scene that begins here, or, with
    `is_first`, in the one that ends here.
    """

    scene: int | None = None
    line: int | None = None
    robots: tuple[str, ...] = ()
    is_first: bool = False


def find_idle(program: Program) -> Mapping[int, Idle]:
    """The lines of a program that do nothing, by index."""
    if not program.scenes and not program.endless:
        return {}  # as most programs
    found: dict[int, Idle] = {}
    endless: int | None = None
    for scene, (first, last) in enumerate(pairwise([-1, *program.breaks, len(program.statements)]), 1):
        playing = [index for index in range(first + 1, last) if program.meanings[index].robots]
        if not playing and program.breaks:
            found[last if first < 0 else first] = Idle(is_first=first < 0)
        if endless:
            found.update(dict.fromkeys(playing, Idle(scene=endless)))
        elif not program.endless.isdisjoint(playing):
            found.update(_kept(program, playing))
            endless = scene
    return found


def _kept(program: Program, playing: Sequence[int]) -> Iterator[tuple[int, Idle]]:
    """The lines of a scene to which all or some of their robots never come."""
    busy: dict[str, int] = {}  # the line that keeps each of these robots
    for index in playing:
        meaning = program.meanings[index]
        robots = tuple([robot for robot in meaning.robots if robot in busy]) if meaning.ok else ()
        if robots:
            yield index, Idle(line=busy[robots[0]], robots=robots)
        if index in program.endless:
            busy = {robot: index for robot, part in meaning.parts if never_ends(part)} | busy
