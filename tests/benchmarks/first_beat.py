"""How much of the first movement twelve robots miss whose processes, and whose stage, have just been started."""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.benchmarks.robots import ENV, LIMIT, Heard, Listener
from tests.benchmarks.tables import machine, print_head, print_row
from tests.commands.command_line import IMPROV

ROBOTS = [f"r{number}" for number in range(12)]
PROCESSES = 12
SECONDS = 2.0
"""How long the first movement takes: two beats at 60 a minute."""
MOST = 20.0
"""Milliseconds of it that a robot may miss."""


def run(quick: bool) -> None:
    """Measure and print; `quick` begins twice instead of ten times."""
    print(f"{machine()}\n")
    print(f"Milliseconds by which the first movement of {len(ROBOTS)} robots was short, as they heard it\n")
    print_head("run", "median", "worst", "missed", "over 20 ms")
    found: list[float | None] = []
    for number in range(2 if quick else 10):
        shorter = _begin()
        found += shorter
        known = sorted(each for each in shorter if each is not None)
        worst = f"{known[len(known) // 2]:.1f}", f"{known[-1]:.1f}" if known else "–"
        print_row(f"{number + 1}", *worst, f"{shorter.count(None)}", f"{sum(each > MOST for each in known)}")
    wrong = sum(each is None or each > MOST for each in found)
    print(f"\n{wrong} of {len(found)} were short by more than {MOST:g} ms, or missed")


def _begin() -> list[float | None]:
    """By how much each robot's first movement is short, in ms; None if it missed all of it."""
    topics = [f"/{robot}/cmd_vel" for robot in ROBOTS]
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(PROCESSES) as threads:
        Path(folder, "dance.improv").write_text(f"{' '.join(ROBOTS)} $ forward forward left\n")
        command = [*IMPROV, "play", "--backend", "ros", "--no-browser", "dance.improv"]
        playing = subprocess.Popen(command, cwd=folder, env=ENV, stdin=subprocess.DEVNULL)
        begun = threads.map(lambda some: Listener("spin", topics[some::PROCESSES]), range(PROCESSES))
        listeners = list(begun)
        playing.wait(LIMIT)
        heard: dict[str, list[Heard]] = {}
        for listener in listeners:
            heard |= listener.end()
    return [_short(heard[topic]) for topic in topics]


def _short(heard: Sequence[Heard]) -> float | None:
    begins = next((each.heard for each in heard if not each.still), None)
    ends = next((each.heard for each in heard if each.yaw), None)
    return None if begins is None or ends is None or begins == ends else 1000 * (SECONDS - (ends - begins))
