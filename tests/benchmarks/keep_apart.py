"""Distance between two robots that drive toward each other and come to rest."""

from __future__ import annotations

import math
import os
import subprocess
import tempfile
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from statistics import median

from tests.benchmarks.air import BASE, LINK, entering, machines, on_air
from tests.benchmarks.hosts import AIR
from tests.benchmarks.robots import ENV, LIMIT, base, end_of
from tests.benchmarks.tables import machine, print_head, print_row
from tests.commands.command_line import IMPROV
from tests.processes import lines_until

LINKS: dict[str, Sequence[str]] = {
    "none: one stage for both": (),
    "2 ms": ("--delay", "0.002"),
    "2–100 ms, 2 % lost": AIR,
}
"""Links to hosts, which need the rights of root."""
RADIUS = 0.164
"""Meters, of a Create 3."""
APART = """
[ros]
odom_frame = "world"
[world]
keep_apart = 0.1
[profiles.base]
base = "create3"
step = 0.3
"""
ROBOT = """
[robots.r{0}]
profile = "base"
odom = "true_pose"
start = {{ x = {1}, y = 0, heading = {2} }}
{3}
"""
STARTS = (0.0, 0), (1.5, 180)
IDEAL = "--noise", "0", "--loss", "0", "--delay", "0.08", "--rests"


def can_have(link: Sequence[str]) -> bool:
    return not link or (os.geteuid() == 0 and LINK.exists())


def rest(link: Sequence[str]) -> float:
    """Return the distance between the edges of two bases at rest that drive toward each other at 0.3 m/s, brake at 0.9
    m/s², and are seen 0.08 s later, if each has a host on such a link, or if they have none."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder, ExitStack() as stack:
        there, here, env, parents_env = [list[str]()] * len(STARTS), list[str](), ENV, ENV
        if link:
            made, reaching = stack.enter_context(machines(len(STARTS), Path(folder), link))
            there, here = [each.by for each in made], entering(BASE)
            env, parents_env = on_air(ENV), on_air(reaching)
        hosts = [f'host = "host{number}"' if link else "" for number in range(len(STARTS))]
        robots = [ROBOT.format(number, *start, hosts[number]) for number, start in enumerate(STARTS)]
        Path(folder, "improv.toml").write_text(APART + "".join(robots))
        Path(folder, "dance.improv").write_text("beat 60\nr0 r1 $ repeat forward\n")
        bases = []
        for number, (x, heading) in enumerate(STARTS):
            start = x, 0, math.radians(heading)
            bases.append(stack.enter_context(base(f"r{number}", start, IDEAL, there[number], env)))
        command = [*here, *IMPROV, "play", "--backend", "ros", "--force", "dance.improv"]
        pipes = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE}
        playing = stack.enter_context(subprocess.Popen(command, cwd=folder, env=parents_env, text=True, **pipes))  # type: ignore[call-overload]
        try:
            lines_until("paused: ", playing.stderr)
            ends = [end_of(each)[0] for each in bases]
        finally:
            playing.terminate()
            playing.communicate(timeout=LIMIT)
    return ends[1] - ends[0] - 2 * RADIUS


def run(quick: bool) -> None:
    """Measure and print; `quick` does it twice instead of 20 times."""
    rounds = 2 if quick else 20
    print(f"{machine()}\n\nMeters between two robots at rest, where `keep_apart` is 0.1\n")
    print_head("link to each host", "times", "least", "median", "most")
    for about, link in LINKS.items():
        if can_have(link):
            gaps = sorted(rest(link) for _ in range(rounds))
            print_row(about, str(len(gaps)), f"{gaps[0]:.3f}", f"{median(gaps):.3f}", f"{gaps[-1]:.3f}")
