"""Times at which robots on bad links change their velocities, with a stage on each of them and with one stage for all.

Each robot is on its own link with random delays and losses. There are saves, pauses, and changes of speed. The
benchmark compares the time at which a robot's own machine has received a change with the beat that the parent's stage
reports. The zeros before beat 0 are no changes, and the stop at the end, which has no time but is obeyed at once,
counts apart. The clocks of the machines differ by thousands of seconds. `IMPROV_ROBOTS` is the number of robots (6).
"""

from __future__ import annotations

import asyncio
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

from improv_core.outputs.ros.setup.interpreter import find_ros_python
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.messages import When
from improv_core.robots.config import read_robots
from improv_core.safety.stops import Stops
from improv_core.score.score import Score
from improv_core.session.acts import News
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import PlayScore
from tests.benchmarks.air import BASE, entering, machines, on_air
from tests.benchmarks.robots import ENV, LIMIT, Heard, Listener
from tests.benchmarks.tables import machine, p99, print_head, print_row

AIR = ("--delay", "0.002", "--jitter", "0.098", "--loss", "0.02")
"""2 to 100 ms each way, and 2 % of all packets lost."""
GAPS = ("--delay", "0.002", "--jitter", "0.02", "--stall", "1:10")
"""Every 10 s, nothing passes for a second."""
STOPS = 0.5
"""Seconds before the message that all have stopped, from which on robots may have stopped."""
PERIOD = 20.0
"""Seconds in which there are a save, a pause, and a change of speed."""
DANCES = "forward left", "left forward"


@dataclass(frozen=True)
class Found:
    """The error of the time of each change in ms, and the messages meanwhile."""

    late: list[float]
    lines: list[str]


def run(quick: bool) -> None:
    """Measure and print; `quick` dances for 40 s instead of five minutes."""
    robots, seconds = int(os.environ.get("IMPROV_ROBOTS", "6")), 40.0 if quick else 300.0
    print(f"{machine()}\n")
    print(f"{robots} robots for {seconds:g} s: how far from its time each change was received, in ms\n")
    print_head("stages", "link", "changes", "median", "p99", "worst")
    rows: list[tuple[str, str, Sequence[str], bool, float]] = [
        ("one for all", "2–100 ms, 2 % lost", AIR, False, 0.5),
        ("one on each", "2–100 ms, 2 % lost", AIR, True, 3.0),
        ("one on each", "1 s of 10 nothing", GAPS, True, 3.0),
    ]
    said: list[str] = []
    for stages, about, link, hosts, patience in rows:
        found = _dance(robots, seconds if link is AIR else min(seconds, 120.0), link, hosts, patience)
        sizes = [abs(each) for each in found.late]
        figures = f"{median(sizes):.1f}", f"{p99(sizes):.1f}", f"{max(sizes):.1f}"
        print_row(stages, about, str(len(sizes)), *figures)
        said += [f"{stages}, {about}: {line}" for line in found.lines]
    print("\n" + "\n".join(dict.fromkeys(said)))


def _dance(robots: int, seconds: float, link: Sequence[str], hosts: bool, patience: float) -> Found:
    with tempfile.TemporaryDirectory(dir="/tmp") as folder, ExitStack() as stack:
        made, env = stack.enter_context(machines(robots, Path(folder), link))
        topics = [f"/r{number}/cmd_vel" for number in range(robots)]
        listeners = [
            stack.enter_context(Listener("drain", [topic], each.by, on_air(ENV)))
            for topic, each in zip(topics, made, strict=True)
        ]
        command = _parent(robots, seconds, hosts, patience)
        playing = subprocess.run(
            command, env=on_air(env), stdout=subprocess.PIPE, text=True, timeout=seconds + 3 * LIMIT, check=True
        )
        told = [json.loads(line) for line in playing.stdout.splitlines()]
        heard: dict[str, list[Heard]] = {}
        for listener in listeners:
            heard |= listener.end()
    return _found(told, heard)


def _parent(robots: int, seconds: float, hosts: bool, patience: float) -> list[str]:
    """Return the command that plays a dance."""
    arguments = [str(robots), str(seconds), "hosts" if hosts else "here", str(patience)]
    return [*entering(BASE), sys.executable, "-m", __name__, *arguments]


def _score(robots: int, hosts: bool, patience: float, dance: str) -> Score:
    """Make a score of robots that all dance alike, each with its own host or none."""
    names = [f"r{number}" for number in range(robots)]
    toml = "".join(
        f'[robots.r{number}]\nhost = "host{number}"\nlink_patience = {patience}\n' for number in range(robots) if hosts
    )
    return score_of(analyze(f"beat 60\n{' '.join(names)} $ repeat ({dance})\n", read_robots(toml)))


async def _perform(robots: int, seconds: float, hosts: bool, patience: float) -> None:
    """Play a dance with saves, pauses, and changes of speed. Print each message that matters, with the time of this
    machine."""
    begun = asyncio.Event()

    def hear(message: News, leads: bool) -> None:
        if leads and message["type"] == "transport":
            if message["state"] == "playing":
                begun.set()
            print(json.dumps({**message, "poses": None}), flush=True)
        elif message["type"] in ("warning", "error", "gone", "link", "unreached"):
            print(json.dumps({**message, "now": time.monotonic()}), flush=True)

    stops = Stops()
    playback = Playback(Options("ros", find_python=find_ros_python), hear, stops)

    async def save(dance: str, when: When) -> None:
        await playback.play(PlayScore(_score(robots, hosts, patience, dance), "dance", stops.count, when))

    try:
        await save(DANCES[0], "restart")
        await asyncio.wait_for(begun.wait(), 60)
        end, period = time.monotonic() + seconds, 0
        while time.monotonic() < end:
            period += 1
            await asyncio.sleep(PERIOD / 4)
            await save(DANCES[period % 2], "beat")
            await asyncio.sleep(PERIOD / 4)
            stops.stop({"type": "pause"})
            await asyncio.sleep(2)
            playback.ask({"type": "resume"}, stops.count)
            await asyncio.sleep(PERIOD / 4 - 2)
            playback.ask({"type": "speed", "factor": 1.25 if period % 2 else 1.0})
            await asyncio.sleep(PERIOD / 4)
    finally:
        await playback.close()


def _found(told: Sequence[Mapping[str, Any]], heard: Mapping[str, Sequence[Heard]]) -> Found:
    moments = [each for each in told if each["type"] == "transport"]
    ended = next((each["monotonic"] for each in moments if each["state"] == "stopped"), math.inf)
    late, stopped = list[float](), list[float]()
    for messages in heard.values():
        all_changes = [two for one, two in pairwise(messages) if one.velocity != two.velocity]
        changes = [each for each in all_changes if each.received < ended - STOPS]
        stopped += [each.received for each in all_changes if each.received >= ended - STOPS][-1:]
        due = [_due(moments, each.received) for each in changes]
        late += [(each.received - at) * 1000 for each, at in zip(changes, due, strict=True)]
    lines = [each["message"] for each in told if each["type"] in ("warning", "error", "gone", "unreached")]
    lines.append(f"the stop at the end reached all within {1000 * (max(stopped) - min(stopped)):.0f} ms")
    links = [each for each in told if each["type"] == "link"]
    if links:
        errors = sorted(1000 * abs(each["offset"] - round(each["offset"], -3)) for each in links)
        lines.append(
            f"clocks were {median(errors):.2f} ms off in the median, {p99(errors):.2f} ms in p99 ({len(links)} looks)"
        )
    return Found(late, lines)


def _due(moments: Sequence[Mapping[str, Any]], at: float) -> float:
    """Return the time at which a change that came then was due: the nearest beat, or the nearest change of the
    playback."""
    known = [each for each in moments if each["monotonic"] <= at + 0.5]
    candidates: list[float] = [each["monotonic"] for each in moments]
    for place, each in enumerate(known):
        if each["state"] != "playing":
            continue
        period = 60 / each["tempo"]
        beat = each["beat"] + (at - each["monotonic"]) / period
        end = moments[place + 1]["monotonic"] if place + 1 < len(moments) else float("inf")
        nearest = each["monotonic"] + (round(beat) - each["beat"]) * period
        if each["monotonic"] - 0.001 <= nearest <= end + 0.001:
            candidates.append(nearest)
    return min(candidates, key=lambda due: abs(due - at))


if __name__ == "__main__":
    asyncio.run(_perform(int(sys.argv[1]), float(sys.argv[2]), sys.argv[3] == "hosts", float(sys.argv[4])))
