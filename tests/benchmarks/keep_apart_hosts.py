"""Two robots that come too near to each other, with a stage for both or on their own hosts: for the benchmark
`keep_apart`.

Run as a module, it is the parent that plays: its argument names the place, and a line on its standard input resumes.
"""

from __future__ import annotations

import asyncio
import json
import queue
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from improv_core.outputs.ros.setup.interpreter import find_ros_python
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.safety.stops import Stops
from improv_core.session.acts import News
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import PlayScore
from tests.benchmarks.air import BASE, entering, machines, on_air
from tests.benchmarks.robots import ENV, HERE, LIMIT, PYTHON

TOML = """
[ros]
odom_frame = "world"
[preflight]
distance = 100
degrees = 180
[world]
keep_apart = 0.3
"""
ROBOT = """
[robots.r{0}]
odom = "pose"
{2}
start = {{ x = {1}, y = 0, heading = 0 }}
"""
PLACES = (0.0, 5.0)
NEAR = 0.7
MOVE, REST = 1.0, 0.5
"""Seconds for which robots move in each round, and for which they stand: then no pose is from before."""


class Delays(NamedTuple):
    """Seconds from a pose to the zeros of the robot that it shows, and to those of the other one; by round."""

    shown: list[float]
    other: list[float]
    lines: list[str]


class Process:
    """A process that prints lines."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self._process = process
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        self.said: list[str] = []
        threading.Thread(target=self._read, daemon=True).start()

    def tell(self, line: str) -> None:
        assert self._process.stdin
        self._process.stdin.write(f"{line}\n")
        self._process.stdin.flush()

    def wait(self, what: str) -> float:
        """Wait for the next line that begins like this, and return its time."""
        end = time.monotonic() + LIMIT
        while True:
            line = ""
            with suppress(queue.Empty):
                line = self._lines.get(timeout=max(end - time.monotonic(), 0.001))
            if not line:
                raise RuntimeError(f"it did not say {what!r}, but {self.said[-10:]}")
            self.said.append(line)
            if line.startswith(what):
                return float(line.split()[-1])

    def forget(self) -> None:
        """Skip the lines so far."""
        while not self._lines.empty():
            self.said.append(self._lines.get())

    def _read(self) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            self._lines.put(line.rstrip())
        self._lines.put("")  # it has ended


@contextmanager
def running(command: Sequence[str], env: Mapping[str, str]) -> Iterator[Process]:
    """Run a process until the context ends."""
    with subprocess.Popen(command, env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            yield Process(process)
        finally:
            assert process.stdin
            process.stdin.close()
            try:
                process.wait(LIMIT)
            except subprocess.TimeoutExpired:
                process.kill()
                raise


def delays(rounds: int, link: Sequence[str]) -> Delays:
    """Return the time until both robots stand in each round, if their hosts are on such links, or if they have none."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder, ExitStack() as stack:
        there, here, env, parents_env = [list[str]()] * len(PLACES), list[str](), ENV, ENV
        if link:
            made, reaching = stack.enter_context(machines(len(PLACES), Path(folder), link))
            there, here = [each.by for each in made], entering(BASE)
            env, parents_env = on_air(ENV), on_air(reaching)
        robots = [
            stack.enter_context(running([*by, PYTHON, str(HERE / "ros_beside.py"), name, str(x)], env))
            for by, name, x in zip(there, ("r0", "r1"), PLACES, strict=True)
        ]
        command = [*here, sys.executable, "-m", "tests.benchmarks.keep_apart_hosts", "hosts" if link else "here"]
        parent = stack.enter_context(running(command, parents_env))
        found = Delays([], [], parent.said)
        for number in range(rounds):
            if number:
                parent.tell("resume")
            for robot in robots:
                robot.wait("moves")
            time.sleep(MOVE)
            for robot in robots:
                robot.forget()
            other, comes = robots
            comes.tell(str(NEAR))
            at = comes.wait("shown")
            found.shown.append(comes.wait("stands") - at)
            found.other.append(other.wait("stands") - at)
            comes.tell(str(PLACES[1]))
            parent.wait("paused")
            time.sleep(REST)
            parent.forget()
    return found


async def perform(hosts: bool) -> None:
    """Play, and print when all are paused, and the lines for people."""

    def hear(message: News, leads: bool) -> None:
        if leads and message["type"] == "transport":
            print(message["state"], message["monotonic"], flush=True)
        elif message["type"] in ("warning", "error", "gone", "unreached"):
            print(json.dumps(message), flush=True)

    lines = [f'host = "host{number}"' if hosts else "" for number in range(len(PLACES))]
    toml = TOML + "".join(ROBOT.format(number, x, lines[number]) for number, x in enumerate(PLACES))
    score = score_of(analyze("r0 r1 $ repeat scale 1/100 (forward backward)\n", read_robots(toml)))
    stops = Stops()
    playback = Playback(Options("ros", find_python=find_ros_python), hear, stops)
    try:
        await playback.play(PlayScore(score, "dance", stops.count, "restart"))
        while await asyncio.to_thread(sys.stdin.readline):
            playback.ask({"type": "resume"}, stops.count)
    finally:
        await playback.close()


if __name__ == "__main__":
    asyncio.run(perform(sys.argv[1] == "hosts"))
