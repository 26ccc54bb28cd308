"""`improv place` with simulated bases that slip: their final distances from their places, and the time it takes."""

from __future__ import annotations

import math
import random
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from tests.benchmarks.robots import ENV, base, end_of
from tests.benchmarks.tables import machine, print_head, print_row
from tests.commands.command_line import IMPROV

ROBOTS = "ada", "ben", "cleo", "dan", "eve", "fay"
DELAY = 0.08
"""Seconds by which poses come late."""
TOML = """
[ros]
odom_frame = "world"
[world]
margin = 0.1
[formation]
shape = "grid"
distance = 1
"""


def run(quick: bool) -> None:
    """Measure and print; `quick` does it with three robots."""
    robots = ROBOTS[:3] if quick else ROBOTS
    toml = TOML + "".join(f'[robots.{name}]\nprofile = "turtlebot4"\nodom = "true_pose"\n' for name in robots)
    starts = _scattered(robots)
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "dance.improv").write_text(f"{' '.join(robots)} $ forward\n")
        Path(folder, "improv.toml").write_text(toml)
        places = _places(folder)
        bases = [_base(name, starts[name], number) for number, name in enumerate(robots)]
        began = time.monotonic()
        command = [*IMPROV, "place", "--yes", "--backend", "ros", "--no-browser", "dance.improv"]
        placed = subprocess.run(
            command, cwd=folder, env=ENV, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False
        )
        took = time.monotonic() - began
        ends = {name: end_of(each) for name, each in zip(robots, bases, strict=True)}
    print(placed.stdout + placed.stderr)
    print(f"{machine()}, {took:.0f} s, exit code {placed.returncode}\n")
    print_head("robot", "m before", "° before", "m after", "° after")
    for name in robots:
        (far, turned), (near, left) = _off(starts[name], places[name]), _off(ends[name], places[name])
        print_row(name, f"{far:.2f}", f"{turned:.0f}", f"{near:.3f}", f"{left:.1f}")


def _scattered(robots: Sequence[str]) -> dict[str, tuple[float, float, float]]:
    lots, found = random.Random(1), dict[str, tuple[float, float, float]]()
    while len(found) < len(robots):
        x, y = lots.uniform(-2, 2), lots.uniform(-2, 2)
        if all(math.dist((x, y), other[:2]) > 0.8 for other in found.values()):
            found[robots[len(found)]] = x, y, lots.uniform(-math.pi, math.pi)
    return found


def _places(folder: str) -> dict[str, tuple[float, float, float]]:
    from improv_core.program.compiler import starts_of
    from improv_core.program.files import analyze_file

    poses = starts_of(analyze_file(Path(folder, "dance.improv")))
    return {name: (pose.x, pose.y, pose.heading) for name, pose in poses.items()}


def _base(name: str, start: tuple[float, float, float], number: int) -> subprocess.Popen[str]:
    """Start a base of which one wheel rolls 3 % and the other 5 % less far than it should."""
    errors = ("0.97", "0.95") if number % 2 else ("0.95", "0.97")
    return base(name, start, ["--wheel-error", *errors, "--delay", str(DELAY), "--seed", str(number)])


def _off(pose: Sequence[float], place: Sequence[float]) -> tuple[float, float]:
    return math.dist(pose[:2], place[:2]), math.degrees(abs(math.remainder(pose[2] - place[2], math.tau)))
