"""Find lines that do nothing because of others: those that begin scenes without robots, or follow endless ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from improv_core.program.program import Program, never_ends


class Idle(NamedTuple):
    """The reason why a line does nothing: the `scene` with this number or the `line` with this index above never ends.

    A line keeps these `robots` from this one. Without a scene and a line, nothing plays in the scene that begins here,
    or, with `is_first`, in the one that ends here.
    """

    scene: int | None = None
    line: int | None = None
    robots: tuple[str, ...] = ()
    is_first: bool = False


def find_idle(program: Program) -> Mapping[int, Idle]:
    """Return the lines of a program that do nothing, by index."""
    if not program.scenes and not program.endless:
        return {}  # true for most programs
    found: dict[int, Idle] = {}
    endless: int | None = None
    for scene, (first, last) in enumerate(pairwise([-1, *program.breaks, len(program.statements)]), 1):
        playing = [index for index in range(first + 1, last) if program.meanings[index].robots]
        if not playing and program.breaks:
            found[last if first < 0 else first] = Idle(is_first=first < 0)
        if endless:
            found.update(dict.fromkeys(playing, Idle(scene=endless)))
        elif not program.endless.isdisjoint(playing):
            found.update(_never_reached(program, playing))
            endless = scene
    return found


def _never_reached(program: Program, playing: Sequence[int]) -> Iterator[tuple[int, Idle]]:
    """Yield the lines of a scene that all or some of their robots never reach."""
    busy: dict[str, int] = {}  # the endless line that each of these robots plays
    for index in playing:
        meaning = program.meanings[index]
        robots = tuple([robot for robot in meaning.robots if robot in busy]) if meaning.ok else ()
        if robots:
            yield index, Idle(line=busy[robots[0]], robots=robots)
        if index in program.endless:
            busy = {robot: index for robot, part in meaning.parts if never_ends(part)} | busy
