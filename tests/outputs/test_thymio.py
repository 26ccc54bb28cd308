"""Thymios, in the simulator of their makers: Debian's package `aseba` has it."""

from __future__ import annotations

import asyncio
import os
import queue
import re
import socket
import subprocess
import sys
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path

import pytest

from improv_core.commands.output_check import Row, checks
from improv_core.commands.output_subjects import subject_for
from improv_core.outputs.devices.device import DeviceRobot
from improv_core.outputs.thymio import bus as bus_module
from improv_core.outputs.thymio.bus import Bus, Wire, wire_to
from improv_core.outputs.thymio.program import FED, NEEDED, RobotMemory, program
from improv_core.outputs.thymio.thymio import MOST, UNITS, WHEELS, Thymio, targets
from improv_core.program.files import robots_in
from improv_core.safety.allowed import approve
from improv_core.score.motion import STILL, Pose, Twist
from tests.outputs.playground import LIMIT, Watch, playground
from tests.processes import lines_until

ROBOTS = {"ada": (100, 100), "bob": (255, 150), "carla": (100, 200)}
"""Their places in centimeters: `bob` drives toward a wall."""


class Memory:
    """Keeps what a robot reports."""

    def __init__(self) -> None:
        self.near: queue.SimpleQueue[bool | float] = queue.SimpleQueue()
        self.posed: queue.SimpleQueue[Pose] = queue.SimpleQueue()

    def sense(self, name: str, value: bool | float) -> None:
        if name == "near":
            self.near.put(value)

    def pose(self, pose: Pose) -> None:
        self.posed.put(pose)


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of all robots."""
    with playground(tmp_path_factory.mktemp("playground"), ROBOTS) as found:
        yield found


def test_wheels_turn_as_fast_as_a_velocity_needs() -> None:
    assert targets(STILL) == (0, 0)
    assert targets(Twist(0.1)) == (round(0.1 * UNITS),) * 2
    assert targets(Twist(yaw=1.0)) == (-round(WHEELS / 2 * UNITS), round(WHEELS / 2 * UNITS))
    left, right = targets(Twist(0.3, yaw=1.0))
    assert right == MOST
    assert left / right == pytest.approx((0.3 - WHEELS / 2) / (0.3 + WHEELS / 2), abs=0.01)


def test_firmware_that_lacks_something_is_too_old() -> None:
    memory = RobotMemory(dict.fromkeys(name for name, _ in NEEDED), 80, {"timer0": 1, "tap": 2}, {"leds.top": 0})  # type: ignore[arg-type]
    assert memory.lacks is None
    assert memory._replace(natives={}).lacks == "leds.top"
    assert memory._replace(events={"tap": 2}).lacks == "timer0"
    assert memory._replace(variables={}).lacks == "motor.left.target"


def test_a_program_fits_into_a_robot() -> None:
    variables = {name: 30 + index for index, (name, _) in enumerate(NEEDED)}
    words = program(RobotMemory(variables, 80, {"timer0": 0xFFEE, "tap": 0xFFF5}, {"leds.top": 40}), (1, 0.5, 0))
    assert words[0] == 7
    assert len(words) < 256
    assert all(0 <= word <= 0xFFFF for word in words)


class Pieces:
    """A connection that brings bytes in pieces of the wrong length, and then ends."""

    def __init__(self, *pieces: bytes) -> None:
        self.pieces = [*pieces]
        self.ends = True
        self.read, self.closed = threading.Event(), threading.Event()

    def recv(self) -> bytes:
        if self.pieces:
            return self.pieces.pop(0)
        self.read.set()
        if not self.ends:
            self.closed.wait(LIMIT)
        raise OSError("it was closed there")

    def send(self, data: bytes) -> None:
        pass

    def close(self) -> None:
        self.closed.set()


def test_messages_in_pieces_are_read_and_the_end_of_a_connection_is_no_silence() -> None:
    present = b"\x02\x00\x05\x00\x0c\x90\x05\x00"
    wire: Wire = Pieces(present[:3], present[3:7], present[7:] + b"\x02")
    bus = Bus("tcp:x:1", wire)
    with pytest.raises(OSError, match=r"the connection to tcp:x:1 is lost \(it was closed there\)"):
        bus.find("ada", 6)


@pytest.mark.parametrize(
    ("address", "why"),
    [
        ("tcp:127.0.0.1:1", "nothing answers at tcp:127.0.0.1:1"),
        ("ble:ada", "write the `address` of a Thymio as `serial:PORT` or `tcp:HOST:PORT`"),
        ("tcp:127.0.0.1", "write the `address` of a Thymio"),
    ],
)
def test_an_address_without_a_robot_is_named(address: str, why: str) -> None:
    with pytest.raises(OSError, match=why):
        Bus.join(address)


@pytest.mark.parametrize(
    ("node", "why"),
    [
        (7, "no Thymio 7 is at tcp:x:1: only 5, 6"),
        (None, "several Thymios are at tcp:x:1: add `node`, one of 5, 6"),
    ],
)
def test_a_robot_that_is_not_there_is_named(node: int | None, why: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bus_module, "ANSWER_LIMIT", 0.0)
    monkeypatch.setattr(bus_module, "ASK_PERIOD", 0.01)
    present = b"\x02\x00%c\x00\x0c\x90\x05\x00"
    wire = Pieces(present % 5, present % 6)
    wire.ends = False
    bus = Bus("tcp:x:1", wire)
    wire.read.wait(LIMIT)
    with pytest.raises(OSError, match=re.escape(why)):
        bus.find("ada", node)
    bus.close()


def listed(folder: Path, robot: str, address: str) -> None:
    """Write the improv.toml of a robot, whose address is allowed."""
    node = [*ROBOTS].index(robot) + 1
    about = f'output = "thymio"\nprofile = "thymio2"\naddress = "{address}"\nnode = {node}\n'
    (folder / "improv.toml").write_text(f"[robots.{robot}]\n{about}", encoding="utf-8")
    approve(address)


@pytest.mark.slow("starts the simulator, and four stages")
def test_a_thymio_keeps_what_outputs_promise(address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    listed(tmp_path, "ada", address)

    async def rows() -> list[Row]:
        return [row async for row in checks(subject_for("thymio", None, robots_in(tmp_path / "improv.toml")), LIMIT)]

    found = asyncio.run(rows())
    assert [row for row in found if not row.passed] == []
    assert [row.check for row in found][-2:] == ["is named", "plugged in again"]


@pytest.mark.slow("starts the simulator, and a performance in it")
def test_a_wall_that_is_near_ends_a_dance(address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    listed(tmp_path, "bob", address)
    program = tmp_path / "dance.improv"
    program.write_text("bob $ until near repeat forward\n", encoding="utf-8")
    watch = Watch(address, 2)
    command = [sys.executable, "-m", "improv_core", "play", str(program), "--no-browser"]
    play = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        watch.until(moves=True)
        said, _ = play.communicate(timeout=LIMIT)
        watch.until(moves=False)
    finally:
        play.kill()
        play.communicate()
        watch.close()
    assert play.returncode == 0, said


@contextmanager
def serial_port(address: str) -> Iterator[str]:
    """Yield the name of a serial port at the other end of which is a TCP address."""
    master, slave = os.openpty()
    tty.setraw(slave)
    host, _, port = address.removeprefix("tcp:").partition(":")
    with socket.create_connection((host, int(port))) as link:

        def pump(read: Callable[[int], bytes], write: Callable[[bytes], object]) -> None:
            with suppress(OSError):
                while data := read(4096):
                    write(data)

        threading.Thread(target=pump, args=(link.recv, partial(os.write, master)), daemon=True).start()
        threading.Thread(target=pump, args=(partial(os.read, master), link.sendall), daemon=True).start()
        yield os.ttyname(slave)
        link.shutdown(socket.SHUT_RDWR)
    os.close(slave)
    os.close(master)


@pytest.mark.slow("starts the simulator")
def test_a_thymio_at_a_serial_port_is_driven_by_one_program_at_a_time(address: str) -> None:
    with serial_port(address) as port:
        memory = Memory()
        thymio = Thymio(DeviceRobot("ada", f"serial:{port}", 1, (0, 1, 0)), memory)
        thymio.connect()
        while memory.posed.get(timeout=LIMIT).x < 0.02:
            thymio.drive(Twist(0.1))
        thymio.drive(STILL)
        while not thymio.stands():
            memory.posed.get(timeout=LIMIT)
        with pytest.raises(OSError, match=f"another program uses {port}"):
            wire_to(f"serial:{port}")
        thymio.close()


def test_a_serial_port_that_is_gone_is_named() -> None:
    with pytest.raises(OSError, match="/dev/ttyACM77 can't be opened: plug the robot or its dongle in"):
        wire_to("serial:/dev/ttyACM77")


DRIVES = """
import sys
from improv_core.outputs.devices.device import DeviceRobot
from improv_core.outputs.thymio.thymio import Thymio
from improv_core.score.motion import Twist
from tests.outputs.test_thymio import Memory
memory = Memory()
thymio = Thymio(DeviceRobot("carla", sys.argv[1], 3, (1, 0, 0)), memory)
thymio.connect()
while True:
    thymio.drive(Twist(0.05, yaw=1.0))
    if memory.posed.get().heading > 0.2:
        print("moves", flush=True)
"""


@pytest.mark.slow("starts the simulator")
def test_a_thymio_whose_host_is_killed_stops_by_itself(address: str) -> None:
    watch = Watch(address, 3)
    host = subprocess.Popen([sys.executable, "-c", DRIVES, address], stdout=subprocess.PIPE, text=True)
    lines_until("moves", host.stdout)
    watch.until(moves=True)
    host.kill()
    host.communicate()
    looks = 0
    while not watch.heard.empty():
        watch.heard.get()
    while any(watch.heard.get(timeout=LIMIT)[2:4]):
        looks += 1
    watch.close()
    assert looks <= FED + 1
