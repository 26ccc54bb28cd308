"""How long the worst programs take to analyze, hover, complete, compile and format: nobody's editor may hang."""

from __future__ import annotations

import gc
import random
import time

from improv_core.program.analysis import NO_ROBOTS, analyze
from improv_core.robots.config import Robots, read_robots
from tests.benchmarks.tables import print_head, print_row
from tests.program.huge import CHAINS, LONG
from tests.program.test_fuzz import SOURCES, WORST, use

AT_ONCE, RANDOM_GOAL, WORST_GOAL = 0.05, 1.0, 10.0
"""Seconds of processor time that the diagnostics of a short program with huge movements may take, a random program,
and one made to be slow."""


def run(quick: bool) -> None:
    """Measure and print; `quick` tries fewer random programs."""
    gc.disable()  # thousands of kept statements make a collection slow, whichever program it happens to fall on
    use("r $ forward", 0)  # makes the grammar
    print("Processor time for everything an editor and the command line ask of one program, seconds\n")
    print_head("program", "time", "goal", "")
    for source in SOURCES:
        chance = random.Random(1)
        slowest = max(_seconds(source(chance)) for _ in range(200 if quick else 2_000))
        _print(f"slowest of {source.__name__.replace('_', ' ')}", slowest, RANDOM_GOAL)
        gc.collect()
    for text in WORST:
        _print(f"`{text[:20]!r}`…", _seconds(text), WORST_GOAL)
    for name, text in {**CHAINS, **LONG}.items():
        began = time.process_time()
        assert analyze(text).ok
        _print(f"{name}, first diagnostics", time.process_time() - began, AT_ONCE)
    for what, line in (("unknown words", "r $ forwrd{0}"), ("names like unknown ones", "name{0} = nam{0}")):
        _print_wrong(what, "".join(f"{line.format(number)}\n" for number in range(100_000)))
    burger = read_robots('[robots.r]\nprofile = "turtlebot3_burger"')
    for what, line in (
        ("lines too fast", "r $ fast 1{0} left"),
        ("that move sideways", "r $ left strafeleft"),
    ):
        _print_wrong(what, "".join(f"{line.format(number)}\n" for number in range(100_000)), burger)
    _print("a line of 10 MB", _seconds("r $ " + "left " * 1_999_999), WORST_GOAL)


def _print_wrong(what: str, text: str, robots: Robots = NO_ROBOTS) -> None:
    """How long 100,000 lines with an error each take to be diagnosed, first and after a key at the middle line."""
    began = time.process_time()
    analysis = analyze(text, robots)
    assert analysis.diagnostics
    opened = time.process_time()
    start = text.index("\n", len(text) // 2) + 1
    assert analysis.edited(start, start, "y").diagnostics
    _print(f"100,000 {what}, first diagnostics", opened - began, WORST_GOAL)
    _print(f"100,000 {what}, after a key", time.process_time() - opened, RANDOM_GOAL)


def _seconds(text: str) -> float:
    began = time.process_time()
    use(text, len(text) // 2)
    return time.process_time() - began


def _print(what: str, seconds: float, goal: float) -> None:
    print_row(what, f"{seconds:.3f}", f"≤ {goal:g}", "met" if seconds <= goal else "not met")
