"""Error of the time at which the first velocity is sent, after `improv play --at`.

Each start is requested 3 s ahead, at another fraction of a second.
"""

from __future__ import annotations

import asyncio
import time
from statistics import median

from improv_core.outputs.ros.setup.interpreter import find_ros_python
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.safety.stops import Stops
from improv_core.session.acts import News
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import PlayScore
from tests.benchmarks.tables import print_head, print_row

AHEAD = 3.0
PROGRAM = "beat 600\na b c d $ forward left\n"


async def measure(backend: str, starts: int) -> list[float]:
    """Return how late each start was, in milliseconds."""
    sent: asyncio.Queue[int] = asyncio.Queue()
    ended = asyncio.Event()

    def hear(message: News, leads: bool) -> None:
        if message["type"] == "sent" and leads and any(message.get("twist", ())):
            sent.put_nowait(message["wall"])
        elif message["type"] == "transport" and leads and message["state"] == "ended":
            ended.set()

    playback = Playback(Options(backend, find_python=find_ros_python, report_sent=True), hear, Stops())
    late = []
    try:
        for number in range(starts):
            ended.clear()
            begins = time.time() + AHEAD + number / starts
            await playback.play(PlayScore(score_of(analyze(PROGRAM)), "dance", 0, arming={"begins": begins}))
            late.append((await sent.get() / 1e9 - begins) * 1e3)
            await ended.wait()
            while not sent.empty():
                sent.get_nowait()
    finally:
        await playback.close()
    return late


def run(quick: bool) -> None:
    """Print the time between the requested start and the first velocity."""
    late = asyncio.run(measure("sim", 5 if quick else 20))
    print_head("starts", "median", "worst", "earliest")
    print_row(str(len(late)), *(f"{each:.2f} ms" for each in (median(late), max(late, key=abs), min(late))))
