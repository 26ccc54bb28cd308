"""A Thymio among twelve in their makers' simulator: from a save to its motors, from a kill to zeros, its squares."""

from __future__ import annotations

import math
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory

from improv_core.outputs.thymio.bus import SET_VARIABLES, Bus, wire_to
from improv_core.outputs.thymio.program import PERIOD
from improv_core.outputs.thymio.thymio import advanced, targets
from improv_core.safety.allowed import approve
from improv_core.score.motion import Pose, Twist
from tests.benchmarks.documents import Edit
from tests.benchmarks.servers import Server
from tests.benchmarks.tables import machine, p99, print_head, print_row
from tests.outputs.playground import LIMIT, Watch, playground
from tests.processes import command_of, descendants, lines_until

STEP = 0.1
"""Meters of `forward`."""
REPEATED = 5
"""The repeats of new motor targets before the next save, twenty a second."""
ROBOTS = {f"t{number}": (50 + 70 * (number % 4), 75 + 75 * (number // 4)) for number in range(12)}
"""Twelve robots, and their places in centimeters."""


class Tap:
    """A connection on the way to the robots, which notes when each gets which motor targets."""

    def __init__(self, to: str) -> None:
        self._to = "127.0.0.1", int(to.rpartition(":")[2])
        self._server = socket.create_server(("127.0.0.1", 0))
        self.address = f"tcp:127.0.0.1:{self._server.getsockname()[1]}"
        self.heard: list[tuple[float, int, tuple[int, int]]] = []
        self._changed = threading.Condition()
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while True:
            here, _ = self._server.accept()
            there = socket.create_connection(self._to)
            for each in (here, there):
                each.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            threading.Thread(target=self._pump, args=(here, there, True), daemon=True).start()
            threading.Thread(target=self._pump, args=(there, here, False), daemon=True).start()

    def _pump(self, here: socket.socket, there: socket.socket, notes: bool) -> None:
        waiting = b""
        try:
            while data := here.recv(65536):
                at = time.perf_counter()
                there.sendall(data)
                waiting += data if notes else b""
                while len(waiting) >= 6 and len(waiting) >= 6 + (length := struct.unpack_from("<H", waiting)[0]):
                    if struct.unpack_from("<H", waiting, 4)[0] == SET_VARIABLES and length == 8:
                        node, _, left, right = struct.unpack_from("<HHhh", waiting, 6)
                        with self._changed:
                            self.heard.append((at, node, (left, right)))
                            self._changed.notify_all()
                    waiting = waiting[6 + length :]
        except OSError:
            pass
        there.close()

    def first(self, node: int, wanted: tuple[int, int], since: float) -> float:
        """Wait until these targets have come and been repeated, and return when they came first."""

        def times() -> list[float]:
            return [at for at, number, both in self.heard if at >= since and number == node and both == wanted]

        with self._changed:
            assert self._changed.wait_for(lambda: len(times()) > REPEATED, LIMIT), f"{wanted} never came"
            return times()[0]


def run(quick: bool = False) -> None:
    """Print the figures."""
    print(machine())
    with TemporaryDirectory() as name:
        folder = Path(name)
        os.environ["XDG_CONFIG_HOME"] = str(folder / "config")
        with playground(folder, ROBOTS) as address:
            tap = Tap(address)
            approve(tap.address)
            _list(folder, tap.address)
            print_head("what", "p50", "p99", "max", "number")
            times = _saves(folder, tap, 10 if quick else 60)
            figures = (f"{each:.1f}" for each in (median(times), p99(times), max(times)))
            print_row("save → motor target, ms", *figures, str(len(times)))
            for what, took, looks in _kills(folder, address):
                print(f"{what} killed: motors at 0 after {took:.2f} s, {looks * PERIOD} ms of the robot's own")
        with playground(folder, {"t0": (150, 150)}) as address:
            print("squares after calibration end so many cm from their starts (at this share of real time):")
            closed = [_calibrated(folder, address) for _ in range(5)]
            for what, index in (("open loop", 0), ("followed", 1)):
                print(f"{what}: " + ", ".join(f"{100 * run[index][0]:.1f} ({run[index][1]:.0%})" for run in closed))


def _saves(folder: Path, tap: Tap, count: int) -> list[float]:
    """Return the milliseconds from each save to the motor targets of its robot."""
    times = []
    uri = (folder / "dance.improv").as_uri()
    with Server({"backend": "ros", "page": {"open": False}}, uri=uri) as server:
        server.open("beat 20\nt0 $ repeat forward\n")
        for beat in range(20, 20 + count):
            begin = server.save()
            came = tap.first(1, targets(Twist(STEP * beat / 60)), begin)
            times.append(1000 * (came - begin))
            server.change(Edit(0, len(f"beat {beat}"), f"beat {beat + 1}", False))
    return times[1:]  # the first one starts the stage


@contextmanager
def _played(folder: Path, program: str) -> Iterator[subprocess.Popen[str]]:
    (folder / "dance.improv").write_text(program, encoding="utf-8")
    command = [sys.executable, "-m", "improv_core", "play", str(folder / "dance.improv"), "--no-browser"]
    play = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        lines_until("▶", play.stdout)
        yield play
    finally:
        play.kill()
        play.communicate()


def _list(folder: Path, address: str, follow: bool = False, **measured: float) -> None:
    """Write the improv.toml of the robots, whose profile has these measures."""
    about = f'output = "thymio"\nprofile = "measured"\naddress = "{address}"\n'
    about += 'odom = "odom"\nfollow = true\n' if follow else ""
    listed = [f"[robots.{robot}]\n{about}node = {node}\n" for node, robot in enumerate(ROBOTS, 1)]
    keys = [f"{key} = {value}\n" for key, value in measured.items()]
    text = "".join([*listed, '[profiles.measured]\nbase = "thymio2"\n', *keys])
    (folder / "improv.toml").write_text(text, encoding="utf-8")


def _dance(folder: Path, address: str, program: str) -> tuple[Pose, float]:
    """Play a program. Return the pose at which its robot ends, as its wheels report, and the share of real time."""
    bus = Bus("odometry", wire_to(address))
    odometer, began = Odometer(bus), time.monotonic()
    with _played(folder, program) as play:
        play.communicate(timeout=3 * LIMIT)
    odometer.wait_until_it_stands()
    bus.close()
    return odometer.pose, odometer.seconds / (time.monotonic() - began)


def _calibrated(folder: Path, address: str) -> list[tuple[float, float]]:
    """Return how far from its start a square ends, in meters, after a robot's steps and turns were measured, and the
    share of real time; then the same if the robot also follows."""
    approve(address)
    _list(folder, address)
    ahead, _ = _dance(folder, address, "t0 $ repeat 4 forward\n")
    turned, _ = _dance(folder, address, "t0 $ repeat 4 left\n")
    step, turn = STEP * 4 * STEP / ahead.x, 90 * math.tau / turned.heading
    found = []
    for follow in (False, True):
        _list(folder, address, follow, commanded_step=step, commanded_quarter_turn=turn)
        end, pace = _dance(folder, address, "t0 $ repeat 4 (forward left)\n")
        found.append((math.hypot(end.x, end.y), pace))
    return found


class Odometer:
    """The pose of robot 1 by its wheels, in its own time."""

    def __init__(self, bus: Bus) -> None:
        self.pose = Pose()
        self.seconds = 0.0
        self._before: Sequence[int] | None = None
        self._stands = True
        self._changed = threading.Condition()
        bus.listen(bus.find("", 1), self._take)

    def _take(self, words: Sequence[int]) -> None:
        before, self._before = self._before or words, words
        with self._changed:
            self.pose = advanced(self.pose, before, words)
            self.seconds += (words[0] - before[0]) % 65_536 * PERIOD / 1000
            self._stands = [*before[2:6]] == [*words[2:4], 0, 0]
            self._changed.notify_all()

    def wait_until_it_stands(self) -> None:
        with self._changed:
            since = self.seconds
            assert self._changed.wait_for(lambda: self.seconds > since and self._stands, LIMIT), "it reports nothing"


def _kills(folder: Path, address: str) -> Iterator[tuple[str, float, int]]:
    """Kill each process that plays. Yield the seconds until the motors are at 0, and the looks of the robot's program
    until then."""
    watch = Watch(address, 1)
    names: Mapping[str, bytes] = {"session": b"", "stage": b"devices", "page": b"/page"}
    for what, word in names.items():
        with _played(folder, "t0 $ repeat slow 4 left\n") as play:
            watch.until(moves=True)
            ours = descendants(play.pid)
            pid = next((pid for pid in ours if word in command_of(pid)), play.pid) if word else play.pid
            os.kill(pid, signal.SIGKILL)
            began, looks = time.monotonic(), 0
            while not watch.heard.empty():
                watch.heard.get()
            while any(watch.heard.get(timeout=LIMIT)[4:6]):
                looks += 1
            yield what, time.monotonic() - began, looks
    watch.close()
