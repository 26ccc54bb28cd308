"""What words for body parts cost: a key in a long program with them, and in the same program without."""

from __future__ import annotations

import time
from statistics import median

from improv_core.program.analysis import Analysis, analyze
from improv_core.program.joint_check import check_joints
from tests.benchmarks.tables import print_row

LINES = 1_000
GOAL = 1.2
"""How many times as long a key may take."""


def run(quick: bool) -> None:
    """Measure and print; `quick` takes fewer rounds."""
    rounds = 20 if quick else 100
    print_row("", "ms without", "ms with", "times", "goal")
    programs = [analyze(_program(parts)) for parts in (False, True)]
    for name, share in (("a key near the start", 0.01), ("in the middle", 0.5), ("near the end", 0.99)):
        without, with_parts = _keys(programs, share, rounds)
        print_row(name, f"{without:.2f}", f"{with_parts:.2f}", f"{with_parts / without:.2f}", f"{GOAL}")
    begun = time.perf_counter()
    check_joints(programs[1])
    print(f"joints are checked in {(time.perf_counter() - begun) * 1000:.0f} ms, beside the keys")


def _keys(programs: list[Analysis], share: float, rounds: int) -> list[float]:
    """The median milliseconds from a key to all diagnostics, for each program, in turns."""
    took: list[list[float]] = [[] for _ in programs]
    for _ in range(rounds):
        for analysis, found in zip(programs, took, strict=True):
            place = analysis.text.index("forward", int(len(analysis.text) * share) - 60)
            begun = time.perf_counter()
            _ = analysis.edited(place, place, "left ").diagnostics
            found.append((time.perf_counter() - begun) * 1000)
    return [median(each) for each in took]


def _program(parts: bool) -> str:
    """So many lines. Without parts, the same words move the base."""
    head, arms = ("head ", "arms ") if parts else ("", "")
    lines = ["ada is puppet", "bo is puppet"]
    for number in range((LINES - 2) // 3):
        lines.append(f"x{number} = {head}(left right) fast 2 {arms}(up down) forward")
        lines.append(f"ada $ x{number} {head}left slow 2 forward || {arms}(up down)")
        lines.append(f"bo $ x{number} reflect sagittal {head}(left right)")
    return "\n".join(lines) + "\n"
