"""How far the changes of real robots, as a subscriber receives them, are from the beats of the MIDI clock they follow.

The clock is simulated, and a backend of mido hears it as bytes in a named pipe. From there on, everything is real: the
process that listens, the parent, the stage with its own clock, ROS 2. Its ticks come up to 5 ms early or late, it is
200 ppm too fast, its tempo rises from 90 to 140 beats per minute, and it is silent for a second.
"""

from __future__ import annotations

import asyncio
import json
import os
import random
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import NamedTuple

from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.safety.stops import Stops
from improv_core.score.score import OutsideClock
from improv_core.session.acts import News
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import PlayScore
from tests.benchmarks.robots import ENV, PYTHON, Heard, Listener
from tests.benchmarks.tables import machine, p99, print_head, print_row

ROBOTS = ["ada", "bert", "cleo"]
PROGRAM = f"beat 120\nbar 4\n{' '.join(ROBOTS)} $ repeat (forward left)\n"
"""A change at each beat."""
JITTER, DRIFT, FROM, TO, SILENCE, SETTLES = 0.005, 200e-6, 90, 140, 1.0, 4.0
TICKS = 24
CABLE = Path(__file__).parents[1] / "playback"
"""Where the backend is."""


class Music(NamedTuple):
    """A clock that runs for some seconds: the second fifth of them is the ramp, and the silence begins after three."""

    seconds: float

    def beat(self, at: float) -> float:
        """Where it is at a time since its start."""
        ramp = self.seconds / 5
        passed = min(max(at - ramp, 0.0), ramp)
        after = max(at - 2 * ramp, 0.0)
        return (FROM * at + (TO - FROM) * (passed * passed / 2 / ramp + after)) / 60 * (1 + DRIFT)

    def rate(self, at: float) -> float:
        return (self.beat(at + 0.001) - self.beat(at - 0.001)) / 0.002

    def is_silent(self, at: float) -> bool:
        return 0 <= at - self.seconds * 3 / 5 < SILENCE

    def ticks(self) -> list[float]:
        """When its ticks are due."""
        at, found = 0.0, list[float]()
        while at < self.seconds:
            found.append(at)
            for _ in range(3):  # Newton's method
                at += (len(found) / TICKS - self.beat(at)) / self.rate(at)
        return found


def play_on(path: str, seconds: float) -> None:
    """In a process of its own: play on a cable, and print when that began, in monotonic seconds, and how late ticks
    were, in ms: 99 of 100 were less."""
    music, chance, late = Music(seconds), random.Random(1), list[float]()
    with suppress(OSError):  # this needs the rights of root
        os.nice(-10)
    with Path(path).open("wb", buffering=0) as cable:
        zero = time.monotonic() + 0.1
        cable.write(b"\xfa")
        for due in music.ticks():
            at = zero + due + chance.uniform(-JITTER, JITTER)
            time.sleep(max(at - time.monotonic(), 0))
            late.append(time.monotonic() - at)
            if not music.is_silent(due):
                cable.write(b"\xf8")
    print(json.dumps([zero, p99(late) * 1000]))


def run(quick: bool) -> None:
    """Measure and print; `quick` takes one minute instead of five."""
    music = Music(60.0 if quick else 300.0)
    print(f"{machine()}; {music.seconds:g} s\n")
    os.environ.update(ENV)
    with tempfile.TemporaryDirectory() as folder, Listener("spin", [f"/{robot}/cmd_vel" for robot in ROBOTS]) as robots:
        cable = Path(folder, "cable")
        os.mkfifo(cable)
        os.environ.update(MIDO_BACKEND="midi_cable", MIDI_CABLE=str(cable), PYTHONPATH=str(CABLE))
        zero, late, bends = asyncio.run(_dance(cable, music))
        heard = robots.end()
    print(f"99 of 100 ticks of the clock were sent less than {late:.1f} ms late, apart from their jitter\n")
    print(
        "How far changes are from the beats of the clock, in ms, and how much longer or shorter a beat is than there\n"
    )
    print_head("robot", "beats", "median", "p99", "worst", "step", "tempo set")
    for topic, messages in heard.items():
        changes = [at - zero for at in _changes(messages)]
        off_by = [(at, (music.beat(at) - round(music.beat(at))) / music.rate(at) * 1000) for at in changes]
        known = [each for at, each in off_by if at >= changes[0] + SETTLES]
        off = [abs(each) for each in known]
        apart = max(abs(later - earlier) for earlier, later in pairwise(known))
        beats = round(music.beat(changes[-1])) - round(music.beat(changes[0])) + 1
        count = f"{len(changes)} of {beats}"
        print_row(topic, count, f"{median(off):.1f}", f"{p99(off):.1f}", f"{max(off):.1f}", f"{apart:.1f}", f"{bends}×")


def _changes(messages: Sequence[Heard]) -> list[float]:
    """When a robot began to drive, or to turn."""
    moving = [each for each in messages if not each.still]
    return [later.received for earlier, later in pairwise(moving) if (earlier.x > 0) != (later.x > 0)]


async def _dance(cable: Path, music: Music) -> tuple[float, float, int]:
    """Have robots follow the clock, until it ends. Returns what it prints, and how often their tempo was set."""
    tempos: list[float] = []

    def hear(message: News, leads: bool) -> None:
        if message["type"] == "transport" and leads and message["state"] == "playing":
            tempos.append(message["tempo"])
        elif message["type"] in ("warning", "error", "gone"):
            print(f"({message})")  # such as that the silence was noticed

    code = f"from tests.benchmarks.clock import play_on; play_on({str(cable)!r}, {music.seconds})"
    playback = Playback(Options("ros", ros_python=PYTHON), hear, Stops())
    try:
        await playback.open()
        peer = await asyncio.create_subprocess_exec(
            sys.executable, "-c", code, stdout=asyncio.subprocess.PIPE, cwd=Path(__file__).parents[2]
        )
        await playback.play(PlayScore(replace(score_of(analyze(PROGRAM)), clock=OutsideClock("midi")), "dance", 0))
        printed, _ = await peer.communicate()
    finally:
        await playback.close()
    zero, late = json.loads(printed)
    return zero, late, len(tempos)
