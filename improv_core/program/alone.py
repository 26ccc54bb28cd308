"""Find a robot that waits for something to be near it although it is alone on a floor without walls."""

from __future__ import annotations

from typing import NamedTuple

from improv_core.program.conditions import conditions
from improv_core.program.program import Program
from improv_core.score.senses import NEAR
from improv_core.slices import checkpoint
from improv_core.text import Span


class Alone(NamedTuple):
    """A `robot` that nothing ever comes near in the simulator, and the first `near` in the program.

    `line` is the index of that statement, and the span counts from its start.
    """

    robot: str
    line: int
    span: Span


def find_alone(program: Program) -> Alone | None:
    """Return the only robot of a program, if it reads `near` and nothing else can be near it.

    A robot whose profile in `improv.toml` sets `near` is not returned: it may be a real one that senses it.
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
            index in others for others in (program.faulty, program.infeasible, program.bindings.unused)
        ):
            checkpoint()
            for _, condition in conditions(body):
                if condition.sense.text == NEAR:
                    return index, condition.sense.span
    return None
