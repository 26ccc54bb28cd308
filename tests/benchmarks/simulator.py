"""How many seconds of dance a second of computing makes, beside bare pymunk; and what the page costs."""

from __future__ import annotations

import math
import os
import platform
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from statistics import median

import pymunk

from improv_core.commands.rehearsal import perform
from improv_core.outputs.simulator.simulator import Simulator
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.start_poses import APART, SIDE_BY_SIDE
from improv_core.score.dynamics import STEPS_PER_SECOND
from improv_core.score.motion import Pose
from improv_core.score.score import Score
from improv_core.score.world import World
from tests.benchmarks import page
from tests.benchmarks.tables import print_head, print_row

GOALS = {1: 500, 100: 30, 1_000: 3}
"""Times real time, for so many robots that never meet."""
HALL = World(size=(12, 12))
RADIUS = 0.3


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the same with fewer rounds."""
    rounds = 3 if quick else 7
    print(f"{len(os.sched_getaffinity(0))} cores, {platform.system()}, Python {platform.python_version()}\n")
    print(f"Times real time, without a page, median (least, most) of {rounds} rounds, side by side\n")
    print_head("robots", "ours, with player", "bare pymunk", "ratio", "goal", "")
    for robots, goal in GOALS.items():
        seconds = 600 / robots**0.6
        score = _squares(robots)
        ours, bare = _side_by_side(partial(_ours, score, seconds), partial(_bare, robots, seconds), rounds)
        verdict = "met" if median(ours) >= goal else "not met"
        print_row(f"{robots:,}", _told(ours), _told(bare), f"{median(ours) / median(bare):.1f}", f"≥ {goal}", verdict)
    for what, score in (
        ("100 with motors", _with_motors(_squares(100))),
        ("100 that push each other in a hall of 12 x 12 m", _crowded(_squares(100))),
    ):
        print_row(what, _told([_ours(score, 4.0) for _ in range(rounds)]), "", "", "", "shown")
    print()
    page.run(quick)


def _squares(robots: int) -> Score:
    return score_of(analyze("\n".join(f"r{number} $ repeat (forward left)" for number in range(robots))))


def _with_motors(score: Score) -> Score:
    parts = {
        name: replace(part, profile=replace(part.profile, dynamics="motors")) for name, part in score.parts.items()
    }
    return replace(score, parts=parts)


def _crowded(score: Score) -> Score:
    parts = {}
    for place, (name, part) in enumerate(score.parts.items()):
        row, column = divmod(place, 10)
        parts[name] = replace(part, start=Pose(1.1 * (column - 4.5), 1.1 * (row - 4.5), heading=float(place)))
    return replace(score, parts=parts, world=HALL)


def _ours(score: Score, seconds: float) -> float:
    began = time.perf_counter()
    perform(score, Simulator(period=None), seconds)
    return seconds / (time.perf_counter() - began)


def _bare(robots: int, seconds: float) -> float:
    """The same squares in pymunk alone, at as many steps. A velocity is set in each, as arcs need it."""
    space = pymunk.Space()
    bodies = []
    for number in range(robots):
        body = pymunk.Body(1.0, pymunk.moment_for_circle(1.0, 0.0, RADIUS))
        behind, beside = divmod(number, SIDE_BY_SIDE)
        body.position = (-APART * behind, -APART * beside)
        space.add(body, pymunk.Circle(body, RADIUS))
        bodies.append(body)
    began = time.perf_counter()
    for second in range(max(int(seconds), 1)):
        speed, turn = (2.0, 0.0) if second % 2 == 0 else (0.0, math.pi / 2)
        for _ in range(STEPS_PER_SECOND):
            for body in bodies:
                body.velocity, body.angular_velocity = body.rotation_vector * speed, turn
            space.step(1 / STEPS_PER_SECOND)
    return max(int(seconds), 1) / (time.perf_counter() - began)


def _side_by_side(one: Callable[[], float], other: Callable[[], float], rounds: int) -> tuple[list[float], list[float]]:
    pairs = [(one(), other()) for _ in range(rounds)]
    return [pair[0] for pair in pairs], [pair[1] for pair in pairs]


def _told(factors: list[float]) -> str:
    return f"{median(factors):,.1f} ({min(factors):,.1f}, {max(factors):,.1f})"
