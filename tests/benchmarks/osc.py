"""How punctual robots and what OSC messages say are, beside a program that floods the OSC port, and how soon a stop
among these messages stops the robots.

The flood is 10,000 datagrams a second from a process of its own: a third of them asks for nothing that there is, a
third is broken, and a third gives the cue.
"""

from __future__ import annotations

import asyncio
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from statistics import median
from typing import NamedTuple

from improv_core.music.osc_wire import written
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.messages import TransportMessage
from improv_core.safety.stops import Stops
from improv_core.score.osc import Osc, Peer
from improv_core.session.acts import News
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import PlayScore
from tests.benchmarks.robots import LIMIT
from tests.benchmarks.tables import p99, print_head, print_row

ROBOTS = [f"r{number}" for number in range(10)]
PROGRAM = f"beat 240\nbar 4\n{' '.join(ROBOTS)} $ repeat (forward left)\n"
RATE = 10_000
"""Datagrams in a second."""
BURST = 200
"""The most that are sent at once after the process had to wait: more would only overflow the port."""
AGAIN = 0.1
"""Seconds after which a stop that was not obeyed is sent again, for the flood may have taken its place."""
SINCE_1900 = 2_208_988_800
"""Seconds from the epoch of time tags to that of Unix."""

FLOOD = f"""
import socket, sys, time
from improv_core.music.osc_wire import plain
port = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
to = "127.0.0.1", int(sys.argv[1])
sent = [plain("/improv/dance", [1]), b"#bundle\\0" + bytes(8) + b"\\x7f\\xff\\xff\\xff/a", plain("/improv/cue", [])]
begin, count = time.monotonic(), 0
while True:
    due = int((time.monotonic() - begin) * {RATE})
    for number in range(max(count, due - {BURST}), due):
        port.sendto(sent[number % 3], to)
    count = due
    time.sleep(0.005)
"""


class Measured(NamedTuple):
    """How late things were, in milliseconds: changes of velocity, and what is heard of beats. `stop` is how long it
    took from sending a stop until the robots were told zero."""

    changes: list[float]
    beats: list[float]
    stop: float


class Ear:
    """Two UDP ports: one that hears what Improv says, and one that is free for Improv to listen on."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setblocking(False)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            self.free = int(free.getsockname()[1])
        self.late: list[float] = []

    @property
    def osc(self) -> Osc:
        here = "127.0.0.1"
        return Osc((Peer(here, self.socket.getsockname()[1]),), Peer(here, self.free))

    def hear(self) -> None:
        """Note how late a beat is."""
        datagram = self.socket.recv(4096)
        if b"/improv/beat" in datagram:
            (tag,) = struct.unpack(">Q", datagram[8:16])
            self.late.append((time.time() - (tag / 2**32 - SINCE_1900)) * 1e3)


@contextmanager
def flood(port: int, wanted: bool) -> Iterator[None]:
    if not wanted:
        yield
        return
    with subprocess.Popen([sys.executable, "-c", FLOOD, str(port)]) as process:
        try:
            yield
        finally:
            process.kill()


async def measure(seconds: float, flooded: bool) -> Measured:
    """Play for so long, then stop by OSC."""
    ear, loop = Ear(), asyncio.get_running_loop()
    changed: list[tuple[float, bool]] = []  # when a robot was told to move otherwise, and whether to move
    latest: dict[str, Sequence[float]] = {}
    transports: list[TransportMessage] = []
    playing, stopped = asyncio.Event(), asyncio.Event()

    def hear(message: News, leads: bool) -> None:
        if message["type"] == "sent":
            if message["twist"] != latest.get(message["robot"]):
                changed.append((message["wall"] / 1e9, any(message["twist"])))
            latest[message["robot"]] = message["twist"]
        elif message["type"] == "transport":
            transports.append(message)
            if message["state"] == "playing":
                playing.set()
            elif message["state"] == "stopped":
                stopped.set()

    playback = Playback(Options("sim", report_sent=True), hear, Stops())
    score = replace(score_of(analyze(PROGRAM)), osc=ear.osc)
    loop.add_reader(ear.socket, ear.hear)
    try:
        with flood(ear.free, flooded):
            await playback.play(PlayScore(score, "dance", 0))
            await asyncio.wait_for(playing.wait(), LIMIT)
            await asyncio.sleep(seconds)
            asked = time.time()
            async with asyncio.timeout(LIMIT):
                while not stopped.is_set():
                    ear.socket.sendto(written([("/improv/stop", [])], time.time()), ("127.0.0.1", ear.free))
                    with suppress(TimeoutError):
                        await asyncio.wait_for(stopped.wait(), AGAIN)
    finally:
        await playback.close()
        loop.remove_reader(ear.socket)
        ear.socket.close()
    begins = next(each for each in transports if each["state"] == "playing")
    period = 60 / begins["tempo"]
    late = (at - begins["wall"] - begins["beat"] * period for at, moves in changed if moves)
    changes = [(each + period / 2) % period - period / 2 for each in late]
    zero = min(at for at, moves in changed if not moves and at >= asked)
    return Measured([each * 1e3 for each in changes], ear.late, (zero - asked) * 1e3)


def run(quick: bool) -> None:
    """Print how late changes and beats are, and how long stops take, with and without a flood."""
    rounds, seconds = (2, 8.0) if quick else (10, 30.0)
    print_head("", "changes: p50", "p99", "worst", "beats heard: p50", "p99", "worst", "stops", "p50", "worst")
    for flooded in (False, True):
        measured = [asyncio.run(measure(seconds, flooded)) for _ in range(rounds)]
        changes = [late for each in measured for late in each.changes]
        beats = [late for each in measured for late in each.beats]
        stops = [each.stop for each in measured]
        print_row(
            "10,000 messages a second" if flooded else "calm",
            *_figures(changes),
            *_figures(beats),
            str(len(stops)),
            f"{median(stops):.1f} ms",
            f"{max(stops):.1f} ms",
        )


def _figures(late: Sequence[float]) -> list[str]:
    return [f"{each:.1f} ms" for each in (median(late), p99(late), max(late, key=abs))]
