"""Thymios, in the simulator of their makers: Debian's package `aseba` has it."""

from __future__ import annotations

import asyncio
import fcntl
import os
import queue
import socket
import struct
import subprocess
import sys
import threading
import tty
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from fractions import Fraction
from functools import partial
from pathlib import Path

import pytest

from improv_core.commands import output
from improv_core.commands.output_check import Row, checks
from improv_core.commands.output_subjects import subject_for
from improv_core.outputs.devices.device import DeviceRobot
from improv_core.outputs.devices.sink import DeviceSink
from improv_core.outputs.thymio import bus as bus_module
from improv_core.outputs.thymio.bus import DESCRIBE, DESCRIPTION, LIST_NODES, PRESENT, Bus, wire_to
from improv_core.outputs.thymio.program import MOTOR_PERIOD, NEEDED, RobotMemory, program
from improv_core.outputs.thymio.thymio import MAX_LOOKS, MAX_WHEEL_SPEED, UNITS, WHEELS, Thymio, advanced, targets
from improv_core.program.files import robots_in
from improv_core.safety.allowed import approve
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import THYMIO2
from improv_core.score.score import DeviceAddress, Part, Score
from tests.outputs.playground import LIMIT, Watch, playground
from tests.ros.conftest import be_patient, let_stages_be_late
from tests.waiting import until

ROBOTS = {"ada": (100, 100), "bob": (255, 150)}
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
    assert right == MAX_WHEEL_SPEED
    assert left / right == pytest.approx((0.3 - WHEELS / 2) / (0.3 + WHEELS / 2), abs=0.01)


def test_a_pose_advances_by_as_much_as_wheels_rolled_unless_reports_were_lost_for_long() -> None:
    looks, left, right = 65_535, 32_000, -100
    before = (looks, 0, left, right)
    meter = round(UNITS / MOTOR_PERIOD)

    def after(passed: int, rolled: int, turned: int = 0) -> Pose:
        wheels = ((rolled - turned + left + 32_768) % 65_536 - 32_768, rolled + turned + right)
        return advanced(Pose(), before, ((looks + passed) % 65_536, 0, *wheels))

    assert after(1, meter // 100).x == pytest.approx(0.01, rel=0.01)
    assert after(1, 0, round(meter * WHEELS / 2 / 10)).heading == pytest.approx(0.1, rel=0.01)
    assert after(MAX_LOOKS, meter // 100) == after(1, meter // 100)
    assert after(MAX_LOOKS + 1, meter // 100) == Pose()


def test_firmware_that_lacks_something_is_too_old() -> None:
    variables = {name: 30 for name, _ in NEEDED}
    memory = RobotMemory(variables, 80, {"timer0": 1, "motor": 3, "tap": 2}, {"leds.top": 0})
    assert memory.lacks is None
    assert memory._replace(natives={}).lacks == "leds.top"
    assert memory._replace(events={"tap": 2}).lacks == "timer0"
    assert memory._replace(events={"timer0": 1, "tap": 2}).lacks == "motor"
    assert memory._replace(variables={}).lacks == "motor.left.target"


def test_a_program_fits_into_a_robot() -> None:
    variables = {name: 30 + index for index, (name, _) in enumerate(NEEDED)}
    events = {"timer0": 0xFFEE, "motor": 0xFFF0, "tap": 0xFFF5}
    words = program(RobotMemory(variables, 80, events, {"leds.top": 40}), (1, 0.5, 0))
    assert words[0] == 9
    assert len(words) < 256
    assert all(0 <= word <= 0xFFFF for word in words)


class Robots:
    """Robots at one address that answer, and have nothing but a name in their memory."""

    def __init__(self, *numbers: int) -> None:
        self.numbers = numbers
        self.sent: list[int] = []
        self._answers: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def send(self, data: bytes) -> None:
        (kind,) = struct.unpack_from("<H", data, 4)
        self.sent.append(kind)
        if kind == LIST_NODES:
            for number in self.numbers:
                self._answers.put(struct.pack("<HHHH", 2, number, PRESENT, 5))
        elif kind == DESCRIBE:
            self._answers.put(struct.pack("<HHHx8xHHH", 15, *struct.unpack_from("<H", data, 6), DESCRIPTION, 0, 0, 0))

    def recv(self) -> bytes:
        return self._answers.get()

    def close(self) -> None:
        self._answers.put(b"")


def test_messages_in_pieces_are_read_and_the_end_of_a_connection_is_no_silence() -> None:
    pieces = iter([b"\x02\x00\x05", b"\x00\x0c\x90\x05", b"\x00\x02"])
    wire = Robots()

    def recv() -> bytes:
        for piece in pieces:
            return piece
        raise OSError("it was closed there")

    wire.recv = recv  # type: ignore[method-assign]
    bus = Bus("tcp:x:1", wire)
    with pytest.raises(OSError, match=r"the connection to tcp:x:1 is lost \(it was closed there\)"):
        bus.find("ada", 6)


def test_a_connection_that_takes_no_more_is_lost_for_all_who_use_it() -> None:
    wire = Robots(5)
    bus = Bus("tcp:x:1", wire)

    def send(data: bytes) -> None:
        raise BrokenPipeError(32, "Broken pipe")

    number = bus.find("ada", 5)
    wire.send = send  # type: ignore[method-assign]
    lost = r"the connection to tcp:x:1 is lost \(Broken pipe\)"
    with pytest.raises(OSError, match=lost):
        bus.set(number, (0, (0, 0)))
    with pytest.raises(OSError, match=lost):
        bus.check()


@pytest.mark.parametrize("kind", ["tcp", "serial"])
def test_names_of_one_address_lead_to_one_connection(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "ttyACM0").touch()
    (tmp_path / "by-id").symlink_to(tmp_path / "ttyACM0")
    names = {"tcp": ("localhost:7", "127.0.0.1:7"), "serial": (tmp_path / "by-id", tmp_path / "ttyACM0")}
    monkeypatch.setattr(bus_module, "wire_to", lambda at: Robots(5))
    first, second = (Bus.join(f"{kind}:{name}") for name in names[kind])
    assert first is second
    first.leave()
    second.leave()
    third = Bus.join(f"{kind}:{names[kind][0]}")
    third.leave()
    assert third is not first


@pytest.mark.parametrize(
    ("address", "node", "why"),
    [
        ("tcp:127.0.0.1:1", 1, "nothing answers at tcp:127.0.0.1:1 (Connection refused)"),
        ("tcp:127.0.0.1:0", 1, "write the `address` of a Thymio as `serial:PORT` or `tcp:HOST:PORT`"),
        ("serial:/dev/ttyACM77", 1, "/dev/ttyACM77 can't be opened: plug the robot or its dongle in, and {allow}"),
        ("serial:{taken}", 1, "another program uses {taken}: end it"),
        ("tcp:x:1", 7, "no Thymio 7 is at tcp:x:1: only 5, 6"),
        ("tcp:x:1", None, "several Thymios are at tcp:x:1: add `node`, one of 5, 6"),
        ("tcp:x:1", 6, "another robot here is the Thymio 6, too: give each its own `node`"),
        ("tcp:x:1", 5, "its firmware is too old, it has no `motor.left.target`: update it with Thymio Suite"),
    ],
)
def test_a_robot_that_cannot_be_driven_is_named_in_one_line_and_nothing_moves(
    address: str, node: int | None, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    if node in (7, None):
        monkeypatch.setattr(bus_module, "ANSWER_LIMIT", 0.0)
    wire = Robots(5, 6)
    monkeypatch.setattr(bus_module, "wire_to", lambda at: wire if at == "tcp:x:1" else wire_to(at))
    other = Bus.join("tcp:x:1")  # of a robot that is the Thymio 6
    other.listen(other.find("", 6), lambda words: None)
    with taken_port() as taken:
        address, why = address.format(taken=taken), why.format(taken=taken, allow="allow yourself to use it")
        approve(address)
        sink = DeviceSink("thymio", Thymio, lambda heard: None, lambda line: None)
        part = Part("ada", (), THYMIO2, Pose(), "/ada/cmd_vel", device=DeviceAddress(address, node))
        sink.prepare(Score(Fraction(60), {"ada": part}), restart=True)
        until(lambda: bool(sink.missing().get("ada")))
        sink.send("ada", Twist(0.1), 0.0)
        assert sink.missing() == {"ada": f"ada: {why}"}
        sink.close()
    other.leave()
    assert {*wire.sent} <= {LIST_NODES, DESCRIBE}, "they were asked, and not driven"


@contextmanager
def taken_port() -> Iterator[str]:
    """Yield the name of a serial port that another program uses."""
    master, slave = os.openpty()
    fcntl.flock(slave, fcntl.LOCK_EX)
    yield os.ttyname(slave)
    os.close(slave)
    os.close(master)


def listed(folder: Path, robot: str, address: str) -> None:
    """Write the improv.toml of a robot, whose address is allowed."""
    node = [*ROBOTS].index(robot) + 1
    about = f'output = "thymio"\nprofile = "thymio2"\naddress = "{address}"\nnode = {node}\n'
    (folder / "improv.toml").write_text(f"[robots.{robot}]\n{about}", encoding="utf-8")
    approve(address)


@pytest.mark.slow("starts the simulator, and four stages")
def test_a_thymio_keeps_what_outputs_promise(address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It stops by itself if its stage is halted, so this process may let a stage of a busy machine be late."""
    be_patient(monkeypatch)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    listed(tmp_path, "ada", address)

    async def rows() -> list[Row]:
        subject = subject_for("thymio", None, robots_in(tmp_path / "improv.toml"))
        return [row async for row in checks(subject, output.LIMIT)]

    found = asyncio.run(rows())
    assert [row for row in found if not row.passed] == []
    assert [row.check for row in found][-2:] == ["is named", "plugged in again"]


@pytest.mark.slow("starts the simulator, and a performance in it")
def test_a_wall_that_is_near_ends_a_dance(address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    let_stages_be_late(monkeypatch)
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
def test_a_thymio_at_a_serial_port_drives_until_that_is_unplugged(address: str) -> None:
    with serial_port(address) as port:
        memory = Memory()
        thymio = Thymio(DeviceRobot("ada", f"serial:{port}", 1, (0, 1, 0)), memory)
        thymio.connect()
        while memory.posed.get(timeout=LIMIT).x < 0.02:
            thymio.drive(Twist(0.1))
        thymio.drive(STILL)
        while not thymio.stands():
            memory.posed.get(timeout=LIMIT)
    lines: queue.SimpleQueue[str] = queue.SimpleQueue()

    def is_lost() -> bool:
        try:
            thymio.drive(STILL)
        except OSError as error:
            lines.put(str(error))
        return not lines.empty()

    until(is_lost)
    assert lines.get().startswith(f"the connection to serial:{port} is lost (")
    thymio.close()
