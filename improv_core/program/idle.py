"""Find lines that do nothing because of others, and a robot that waits in vain because it is alone.

Lines do nothing if they begin scenes without robots, or follow endless ones.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from improv_core.program.misuse import conditions
from improv_core.program.program import Program, never_ends
from improv_core.score.senses import NEAR
from improv_core.slices import checkpoint, in_slices
from improv_core.text import Span


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
    endless_lines = {index for index in in_slices(program.unusual.endless) if program.meanings[index].ok}
    if not program.scenes and not endless_lines:
        return {}  # true for most programs
    found: dict[int, Idle] = {}
    endless: int | None = None
    for scene, (first, last) in enumerate(pairwise([-1, *program.breaks, len(program.statements)]), 1):
        playing = [index for index in range(first + 1, last) if program.meanings[index].robots]
        if not playing and program.breaks:
            found[last if first < 0 else first] = Idle(is_first=first < 0)
        if endless:
            found.update(dict.fromkeys(playing, Idle(scene=endless)))
        elif not endless_lines.isdisjoint(playing):
            found.update(_never_reached(program, playing, endless_lines))
            endless = scene
    return found


def _never_reached(program: Program, playing: Sequence[int], endless: Container[int]) -> Iterator[tuple[int, Idle]]:
    """Yield the lines of a scene that all or some of their robots never reach."""
    busy: dict[str, int] = {}  # the endless line that each of these robots plays
    for index in playing:
        meaning = program.meanings[index]
        robots = tuple([robot for robot in meaning.robots if robot in busy]) if meaning.ok else ()
        if robots:
            yield index, Idle(line=busy[robots[0]], robots=robots)
        if index in endless:
            busy = {robot: index for robot, part in meaning.parts if never_ends(part)} | busy


class Alone(NamedTuple):
    """A `robot` that nothing ever comes near in the simulator, and the first `near` in the program.

    `line` is the index of that statement, and the span counts from its start.
    """

    robot: str
    line: int
    span: Span


def find_alone(program: Program) -> Alone | None:
    """Return the only robot of a program, if it reads `near` and nothing else can be near it.

    A robot whose profile in `improv.toml` sets `near` is not returned: it may be a real robot with a sensor.
    """
    config = program.opening.config
    if config.world.has_obstacles or NEAR in config.senses:
        return None
    robots = set(program.opening.places)
    for meaning in program.meanings:
        if meaning.robots:
            robots.update(meaning.robots)
            if len(robots) > 1:
                return None
    for robot in robots:
        if (robot not in config.robots or config.lacks(robot, NEAR)) and (found := _first_near(program)):
            return Alone(robot, *found)
    return None


def _first_near(program: Program) -> tuple[int, Span] | None:
    """Return the first `near` in a program: the statement, and the word in it. Skip statements with other problems."""
    reading = (index for index, statement in enumerate(program.statements) if statement.has_senses)
    for index in reading:
        body = program.meanings[index].body
        if body and not any(
            index in others for others in (program.unusual.faulty, program.infeasible, program.bindings.unused)
        ):
            checkpoint()
            for _, condition in conditions(body):
                if condition.sense.text == NEAR:
                    return index, condition.sense.span
    return None
