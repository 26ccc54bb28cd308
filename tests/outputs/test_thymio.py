"""Thymios, in the simulator of their makers: Debian's package `aseba` has it."""

from __future__ import annotations

import os
import queue
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from improv_core.outputs.devices.device import DeviceRobot
from improv_core.outputs.thymio import bus as bus_module
from improv_core.outputs.thymio.bus import Bus, Wire, wire_to
from improv_core.outputs.thymio.program import FED, NEEDED, RobotMemory, program
from improv_core.outputs.thymio.thymio import MOST, UNITS, WHEELS, Thymio, targets
from improv_core.safety.allowed import approve
from improv_core.score.motion import STILL, Pose, Twist
from tests.needs import need
from tests.processes import lines_until

LIMIT = 60.0
"""Seconds to wait for a simulator on a busy machine, on which it is slower than real time."""
ROBOTS = {"ada": (100, 100), "bob": (287, 150), "carla": (100, 200)}
"""Their places in centimeters: `bob` looks at a wall."""


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
def playground(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The address of all robots: a switch, such as a radio dongle is."""
    need("asebaplayground")
    folder = tmp_path_factory.mktemp("playground")
    ports = [free_port() for _ in ROBOTS]
    robots = "".join(
        f'<robot type="thymio2" x="{x}" y="{y}" angle="0" port="{port}" nodeId="{node}" name="{name}"/>'
        for (node, (name, (x, y))), port in zip(enumerate(ROBOTS.items(), 1), ports, strict=True)
    )
    world = '<color name="white" r="1" g="1" b="1"/><world w="300" h="300" color="white"/>'
    text = f"<!DOCTYPE aseba-playground>\n<aseba-playground>{world}{robots}</aseba-playground>"
    (folder / "world.playground").write_text(text, encoding="utf-8")
    env = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": str(folder)}
    with running([need("xvfb-run"), "-a", need("asebaplayground"), "world.playground"], cwd=folder, env=env):
        for port in ports:
            wait_for(port)
        with switch(*ports, at=(port := free_port())):
            yield f"tcp:127.0.0.1:{port}"


@contextmanager
def running(command: Sequence[str], **options: Any) -> Iterator[None]:
    """Run a program, and end it and all that it has started."""
    nothing = subprocess.DEVNULL
    process = subprocess.Popen(command, stdout=nothing, stderr=nothing, start_new_session=True, **options)
    try:
        yield
    finally:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait(LIMIT)


@contextmanager
def switch(*ports: int, at: int) -> Iterator[None]:
    """Run a switch that joins what listens on these ports, itself on another one."""
    targets = [f"tcp:127.0.0.1;{each}" for each in ports]
    with running([need("asebaswitch"), "-p", str(at), *targets]):
        wait_for(at)
        yield


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


def wait_for(port: int) -> None:
    """Wait until something listens at a port, without a connection: the simulator crashes if that is closed at once."""
    end = time.monotonic() + LIMIT
    listens = f":{port:04X} 00000000:0000 0A"  # proc_net_tcp(5)
    while listens not in Path("/proc/net/tcp").read_text(encoding="ascii"):
        assert time.monotonic() < end, "the simulator doesn't listen"
        time.sleep(0.1)  # nothing reports that it listens


class Watch:
    """Another client, which receives what the program on a robot reports."""

    def __init__(self, address: str, node: int) -> None:
        self.heard: queue.SimpleQueue[Sequence[int]] = queue.SimpleQueue()
        self._bus = Bus(address, wire_to(address))
        self._bus.listen(self._bus.find("", node), self.heard.put)

    def until(self, moves: bool) -> None:
        """Wait for a new report that it moves, or stands."""
        while not self.heard.empty():
            self.heard.get()
        while any(self.heard.get(timeout=LIMIT)[2:4]) != moves:
            pass

    def close(self) -> None:
        self._bus.close()


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


@pytest.mark.slow("starts the simulator")
def test_a_thymio_drives_confirms_its_stop_and_sees_a_wall(playground: str) -> None:
    seen = {}
    for node in (1, 2):
        memory = Memory()
        thymio = Thymio(DeviceRobot("ada", playground, node, (0, 0, 1)), memory)
        thymio.connect()
        seen[node] = memory.near.get(timeout=LIMIT)
        if node == 1:
            while memory.posed.get(timeout=LIMIT).x < 0.05:
                thymio.drive(Twist(0.1))
            thymio.drive(STILL)
            while not thymio.stands():
                memory.posed.get(timeout=LIMIT)
        thymio.close()
    assert seen == {1: False, 2: True}


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
def test_a_thymio_at_a_serial_port_is_driven_by_one_program_at_a_time(playground: str) -> None:
    with serial_port(playground) as port:
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
def test_a_thymio_whose_host_is_killed_stops_by_itself(playground: str) -> None:
    watch = Watch(playground, 3)
    host = subprocess.Popen([sys.executable, "-c", DRIVES, playground], stdout=subprocess.PIPE, text=True)
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


@pytest.mark.slow("starts the simulator, and a performance in it")
def test_a_robot_that_is_cut_off_is_named_stops_and_comes_back(
    playground: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    inner, port = int(playground.rpartition(":")[2]), free_port()
    approve(f"tcp:127.0.0.1:{port}")
    about = f'output = "thymio"\nprofile = "thymio2"\naddress = "tcp:127.0.0.1:{port}"\n'
    robots = f"[robots.ada]\n{about}node = 1\n[robots.carla]\n{about}node = 3\n"
    (tmp_path / "improv.toml").write_text(robots, encoding="utf-8")
    program = tmp_path / "dance.improv"
    program.write_text("ada $ repeat 2000 left\ncarla $ repeat 2000 left\n", encoding="utf-8")
    command = [sys.executable, "-m", "improv_core", "play", str(program), "--no-browser"]
    watch = Watch(playground, 3)
    with switch(inner, at=port):
        play = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        lines_until("▶", play.stdout)
        watch.until(moves=True)
    try:
        lines_until("carla", play.stdout)
        watch.until(moves=False)
        with switch(inner, at=port):
            watch.until(moves=True)
            play.send_signal(signal.SIGINT)
            play.communicate(timeout=LIMIT)
            watch.until(moves=False)
    finally:
        play.kill()
        play.communicate()
        watch.close()
