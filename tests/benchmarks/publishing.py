"""What it costs to publish what plays for others in ROS 2: how late commands are, and processor time."""

from __future__ import annotations

import subprocess
from contextlib import ExitStack
from dataclasses import replace
from resource import RUSAGE_CHILDREN, getrusage
from statistics import median

from tests.benchmarks.live import rehearsed
from tests.benchmarks.robots import ENV, HERE, LIMIT, NOTHING, PYTHON, Lateness, Listener, lateness, play
from tests.benchmarks.tables import machine, p99, print_head, print_row
from tests.stage.test_player import score

CROWD = 20
WATCHER = HERE.parent / "ros" / "watcher.py"
WAYS = {"not published": (False, False), "published": (True, False), "published and watched": (True, True)}
"""Whether it is published, and whether somebody subscribes to all of it."""


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the same for a few seconds each."""
    seconds, rounds = (6, 3) if quick else (20, 5)
    print(f"{machine()}\n")
    print(f"Changes of velocity of {CROWD} robots, {rounds} × {seconds} s in turn: lateness when received, in ms\n")
    print_head("what", "changes", "missing repeats", "p50", "p99", "p50, times", "p99, times", "share of a core")
    found: dict[str, tuple[Lateness, float]] = dict.fromkeys(WAYS, (NOTHING, 0.0))
    for _ in range(rounds):
        for way, (published, watched) in WAYS.items():
            late, share = _commands(seconds, published, watched)
            found[way] = found[way][0] + late, found[way][1] + share / rounds
    alone = found["not published"][0].changes
    for way, (late, share) in found.items():
        figures = (f"{value:.2f}" for value in (median(late.changes), p99(late.changes)))
        ratios = (f"{of(late.changes) / of(alone):.2f}" for of in (median, p99))
        print_row(way, f"{len(late.changes):,}", f"{late.missing}", *figures, *ratios, f"{share:.0%}")


def _commands(seconds: int, published: bool, watched: bool) -> tuple[Lateness, float]:
    """How late commands are, and the share of a core that the stage and its helpers take, from start to end."""
    robots = [f"r{number}" for number in range(CROWD)]
    text = f"{' '.join(robots)} $ repeat {seconds // 2} (forward left)\n"
    with ExitStack() as stack:
        if watched:
            topics = [f"/improv/{robot}/path" for robot in robots]
            command = [PYTHON, str(WATCHER), *topics]
            watcher = subprocess.Popen(command, env=ENV, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
            stack.callback(watcher.communicate, timeout=LIMIT)
        listener = stack.enter_context(Listener("drain", [f"/{robot}/cmd_vel" for robot in robots]))
        before = getrusage(RUSAGE_CHILDREN)
        zero = play(replace(score(text), publish=published))
        after = getrusage(RUSAGE_CHILDREN)
        heard = listener.end()
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return lateness(heard, zero, rehearsed(text)), used / seconds
