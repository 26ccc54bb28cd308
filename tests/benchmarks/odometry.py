"""What the odometry of twenty robots costs: how late commands are with and without it, and the share of a core."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import replace
from statistics import median
from typing import Any

from improv_core.score.score import Score
from tests.benchmarks.live import rehearsed
from tests.benchmarks.robots import ENV, HERE, LIMIT, PYTHON, Lateness, Listener, lateness, play
from tests.benchmarks.servers import processor_time
from tests.benchmarks.tables import machine, p99, print_head, print_row
from tests.processes import command_of, descendants
from tests.stage.test_player import score

ROBOTS = [f"r{number}" for number in range(20)]
MOST = 1.2
"""How many times later commands may be at the median."""


def run(quick: bool) -> None:
    """Measure and print; `quick` measures the same for a few seconds."""
    seconds, rounds = (4, 1) if quick else (20, 3)
    print(f"{machine()}\n")
    print(f"Lateness of changes of velocity to {len(ROBOTS)} robots, {rounds} × {seconds} s in turn, milliseconds;")
    print("their odometry is published 50 times a second each\n")
    print_head("way", "changes", "received p50", "p99", "p50, times", "poses a second", "reader's core", "stage's core")
    late: dict[str, list[float]] = {"no odometry": [], "odometry, not read": [], "odometry that is read": []}
    cost = {way: _Cost() for way in late}
    for _ in range(rounds):
        for way, found in late.items():
            found += _play(seconds, way != "no odometry", way == "odometry that is read", cost[way]).changes
    for way, found in late.items():
        ratio = median(found) / median(late["no odometry"])
        reader, stage = (f"{share / rounds:.1%}" for share in (cost[way].reader, cost[way].stage))
        figures = f"{median(found):.2f}", f"{p99(found):.2f}", f"{ratio:.2f}"
        print_row(way, f"{len(found)}", *figures, f"{cost[way].poses / rounds:.0f}", reader, stage)
    share, heard = _plain(seconds)
    print(f"\nPlain rclpy, which listens to all: {heard:.0f} poses a second, {share:.1%} of a core")
    print(f"The goal of {MOST:g} times is " + ("met" if ratio <= MOST else "not met"))


class _Cost:
    """Poses a second, and the shares of a core that processes take; summed over rounds."""

    def __init__(self) -> None:
        self.poses = self.reader = self.stage = 0.0
        self._began = 0.0, (0.0, 0.0)
        self._poses = 0

    def hear(self, stage: int, message: Mapping[str, Any]) -> None:
        """Add what is known of a round at its end."""
        if message["type"] == "measured":
            self._poses += len(message["robots"])
        elif message.get("state") == "playing":
            self._began, self._poses = (time.monotonic(), _used(stage)), 0
        elif message.get("state") == "ended":
            at, before = self._began
            passed, used = time.monotonic() - at, _used(stage)
            self.poses += self._poses / passed
            self.stage += (used[0] - before[0]) / passed
            self.reader += (used[1] - before[1]) / passed


def _play(seconds: int, published: bool, read: bool, cost: _Cost) -> Lateness:
    text = f"{' '.join(ROBOTS)} $ repeat {seconds // 2} (forward left)\n"
    program = score(text)
    with ExitStack() as stack:
        if published:
            stack.enter_context(_Script("publish"))
        listener = stack.enter_context(Listener("drain", [f"/{robot}/cmd_vel" for robot in ROBOTS]))
        zero = play(_measured(program) if read else program, cost.hear)
        heard = listener.end()
    return lateness(heard, zero, rehearsed(text))


def _used(stage: int) -> tuple[float, float]:
    """The seconds of processor time that a stage and its reader have used."""
    reader = [pid for pid in descendants(stage) if b"\0reader\0" in command_of(pid)]
    return processor_time(stage), sum(map(processor_time, reader))


def _plain(seconds: int) -> tuple[float, float]:
    """The share of a core that a plain script takes, and the poses that it hears a second."""
    with _Script("publish"), _Script("listen") as plain:
        time.sleep(seconds)
        told, _ = plain.communicate(timeout=LIMIT)
    share, heard = map(float, told.split())
    return share, heard


class _Script:
    """ros_odometry.py, until the end of a block."""

    def __init__(self, what: str) -> None:
        pipe = subprocess.PIPE
        command = [PYTHON, str(HERE / "ros_odometry.py"), what, *ROBOTS]
        self._process = subprocess.Popen(command, env=ENV, stdin=pipe, stdout=pipe, text=True)

    def __enter__(self) -> subprocess.Popen[str]:
        assert self._process.stdout
        self._process.stdout.readline()
        return self._process

    def __exit__(self, *failure: object) -> None:
        self._process.kill()
        self._process.wait()


def _measured(program: Score) -> Score:
    return replace(program, parts={name: replace(part, odom=f"/{name}/odom") for name, part in program.parts.items()})
