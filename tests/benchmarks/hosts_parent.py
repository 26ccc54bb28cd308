"""Plays a dance with saves, pauses, and changes of speed, for the benchmark `hosts`, and prints the messages.

Its arguments: the number of robots, the seconds of the dance, `hosts` if each has its own stage, and their patience.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time

from improv_core.outputs.ros.setup.interpreter import find_ros_python
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.robots.config import read_robots
from improv_core.safety.stops import Stops
from improv_core.score.score import Score
from improv_core.session.acts import News
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import PlayScore

PERIOD = 20.0
"""Seconds in which there are a save, a pause, and a change of speed."""
DANCES = "forward left", "left forward"


def score(robots: int, hosts: bool, patience: float, dance: str) -> Score:
    """Make a score of robots that all dance alike, each with its own host or none."""
    names = [f"r{number}" for number in range(robots)]
    toml = "".join(
        f'[robots.r{number}]\nhost = "host{number}"\nlink_patience = {patience}\n' for number in range(robots) if hosts
    )
    return score_of(analyze(f"beat 60\n{' '.join(names)} $ repeat ({dance})\n", read_robots(toml)))


async def perform(robots: int, seconds: float, hosts: bool, patience: float) -> None:
    """Play, and print each message that matters, with the time of this machine."""
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

    async def save(dance: str, when: str) -> None:
        await playback.play(PlayScore(score(robots, hosts, patience, dance), "dance", stops.count, when))  # type: ignore[arg-type]

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


if __name__ == "__main__":
    asyncio.run(perform(int(sys.argv[1]), float(sys.argv[2]), sys.argv[3] == "hosts", float(sys.argv[4])))
