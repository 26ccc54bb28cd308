"""`improv output check`: outputs that keep their promises, and one that doesn't."""

from __future__ import annotations

import socketserver
import threading
from collections.abc import Iterator
from contextlib import chdir, contextmanager, suppress
from pathlib import Path

import pytest
from click.testing import CliRunner

from improv_core.commands import output_check
from improv_core.commands.main import improv
from improv_core.commands.output import command
from improv_core.ide.robots_file.completion import complete
from improv_core.ipc.stage_process import Stage
from improv_core.outputs.ros.setup import interpreter
from improv_core.robots.config import read_robots
from improv_core.safety.allowed import approve
from improv_core.score import installed
from tests.commands.command_line import Running, run, usual_signals, written
from tests.ros.conftest import let_stages_be_late

pytestmark = pytest.mark.slow("starts five stages")

OUTPUT = """
import socket
import threading

from improv_core.outputs.devices.device import Device
from improv_core.score.installed import Setting
from improv_core.score.motion import Twist


class Turning(Device):
    \"\"\"Its robot takes a turning speed in each line, and says it to all.\"\"\"

    stops_after = 0.3
    settings = {"sign": Setting("the direction of a left turn", 1, -1, 1), "quiet": Setting("no sound", False)}

    def connect(self):
        host, _, port = self.robot.address.removeprefix("tcp:").partition(":")
        self.link = socket.create_connection((host, int(port)))
        self.lines = self.link.makefile()
        threading.Thread(target=self.read, daemon=True).start()
        self.report = lambda twist: None
        self.problem = ""

    def read(self):
        for line in self.lines:
            self.report(Twist(yaw=float(line)))
        self.problem = "it has closed the connection"

    def watch(self, report):
        self.connect()
        self.report = report

    def drive(self, twist):
        self.link.sendall(b"%f\\n" % (twist.yaw * self.robot.settings["sign"]))

    def check(self):
        if self.problem:
            raise OSError(self.problem)

    def close(self):
        self.link.close()
"""
LIMIT = 8.0
"""Seconds to a stop, on a machine that does other things, too."""
SOON = 0.3
"""Seconds in which a robot that never stops by itself is found to keep moving, and for which others have to stand."""


class Robot(socketserver.ThreadingTCPServer):
    """A robot that stops by itself after 0.3 s without a line, if it does."""

    daemon_threads = True

    def __init__(self, stops: bool) -> None:
        super().__init__(("127.0.0.1", 0), Talk)
        self.stops = stops
        self.talks: list[Talk] = []
        self.timer = threading.Timer(0, print)

    def turn(self, line: bytes) -> None:
        self.timer.cancel()
        for each in [*self.talks]:
            each.say(line)
        if self.stops:
            self.timer = threading.Timer(0.3, self.turn, [b"0\n"])
            self.timer.start()


class Talk(socketserver.StreamRequestHandler):
    """One connection to it."""

    server: Robot

    def handle(self) -> None:
        self.server.talks.append(self)
        with suppress(OSError):
            for line in self.rfile:
                self.server.turn(line)
        self.server.talks.remove(self)

    def say(self, line: bytes) -> None:
        with suppress(OSError, ValueError):  # it has ended
            self.wfile.write(line)


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder on the path of modules, in which the output is installed."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr(output_check, "QUIET", SOON)
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "turning.py").write_text(OUTPUT)
    about = tmp_path / "turning-1.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: turning\nVersion: 1\n")
    (about / "entry_points.txt").write_text("[improv.outputs]\nturning = turning:Turning\n")
    for each in (installed.outputs_installed, installed.settings_of, read_robots):
        each.cache_clear()
    yield tmp_path
    for each in (installed.outputs_installed, installed.settings_of, read_robots):
        each.cache_clear()


def checked(place: Path, *arguments: str, limit: float = LIMIT) -> tuple[int, dict[str, str]]:
    """Return the exit code, and what was found by each check: `yes`, `NO`, or `-`."""
    with chdir(place):  # the stages are real ones
        ended = CliRunner().invoke(command, ["check", *arguments, "--yes", "--limit", str(limit)])
    return ended.exit_code, {line[:22].rstrip(): line[23:27].strip() for line in ended.stdout.splitlines()}


@contextmanager
def listed(place: Path, stops: bool) -> Iterator[None]:
    """Run a robot of this output, and write an improv.toml that lists it."""
    with Robot(stops) as robot:
        threading.Thread(target=robot.serve_forever).start()
        address = f"tcp:127.0.0.1:{robot.server_address[1]}"
        approve(address)
        about = (
            f'output = "turning"\naddress = "{address}"\nprofile = "turtlebot3_burger"\nsettings = {{ sign = -1 }}\n'
        )
        (place / "improv.toml").write_text(f"[robots.ada]\n{about}")
        yield
        robot.shutdown()


@pytest.mark.parametrize("stops", [True, False])
def test_a_robot_that_does_not_stop_by_itself_is_found(place: Path, stops: bool) -> None:
    with listed(place, stops):
        code, found = checked(place, "turning", limit=LIMIT if stops else SOON)
    by_itself = {"stage killed", "stage halted", "unplugged"}  # after late commands, its stage stops it
    always = {"moves", "within its limits", "is named", "plugged in again"}
    if stops:
        assert (code, {*found.values()}) == (0, {"yes"})
    else:
        assert (code, {found[name] for name in by_itself}, {found[name] for name in always}) == (1, {"NO"}, {"yes"})


def test_a_machine_without_ros_plays_real_robots_of_an_output(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("IMPROV_ROS_PYTHON", raising=False)
    monkeypatch.setattr(interpreter, "_candidates", lambda: iter(()))
    let_stages_be_late(monkeypatch)
    written(place, "ada $ left\n")
    with listed(place, stops=True), chdir(place), usual_signals():  # the stages are real ones
        ended = CliRunner().invoke(improv, ["play", "dance.improv", "--backend", "ros", "--no-browser"])
    assert (ended.exit_code, "at beat 60, turning on turning" in ended.stdout) == (0, True), ended.output


@pytest.mark.parametrize(("command", "line"), [("watch", "turning on turning"), ("edit", "editing dance.improv")])
def test_a_machine_without_ros_watches_and_edits_dances_of_an_output(
    place: Path, monkeypatch: pytest.MonkeyPatch, command: str, line: str
) -> None:
    monkeypatch.delenv("IMPROV_ROS_PYTHON", raising=False)
    monkeypatch.setattr(interpreter, "_candidates", lambda: iter(()))
    written(place, "ada $ left\n")
    with listed(place, stops=True):
        running = Running(command, place / "dance.improv", "--backend", "ros", "--no-browser", stage=Stage)
        running.wait(line)
        running.close()


ABOUT = '[robots.ada]\noutput = "turning"\naddress = "tcp:localhost:1"\n[robots.ada.settings]\n'


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("sing = 1", "`sing` is not valid here: did you mean `sign`?"),
        ("sign = 2", "write `sign` from -1 to 1"),
        ("sign = 0.5", "write `sign` as a whole number"),
        ("quiet = 1", "write `quiet` as `true` or `false`"),
        ("sign = -1", None),
    ],
)
def test_settings_that_an_output_declares_are_checked(place: Path, line: str, message: str | None) -> None:
    found = read_robots(ABOUT + line)
    assert [each.message for each in found.diagnostics] == ([message] if message else [])


def test_a_robot_that_two_outputs_claim_is_reported(place: Path) -> None:
    found = read_robots(ABOUT + ABOUT.replace("ada", "bob").replace("turning", "thymio"))
    line = "`ada` is the robot at this address, too: give each its own `address` or `node`"
    assert [each.message for each in found.diagnostics] == [line]


def test_settings_that_an_output_declares_are_completed(place: Path) -> None:
    text = ABOUT + "sign = 1\n"
    found = complete(text, len(text))
    assert found
    items = {item.label: (item.detail, item.snippet) for item in found.items if item.kind == "key"}
    assert items == {"quiet": ("no sound", "quiet = ${1:false}")}


def test_the_simulator_keeps_its_promises(place: Path) -> None:
    code, found = checked(place, "simulator", limit=60.0)
    assert code == 0, found
    assert [name for name, passed in found.items() if passed == "yes"] == [
        "moves",
        "within its limits",
        "stop",
        "end of a session",
    ]


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["turning"], 'no robot in improv.toml has `output = "turning"`: add one'),
        (["thimyo"], 'no robot in improv.toml has `output = "thimyo"`: add one'),
    ],
)
def test_an_output_without_a_robot_is_named(place: Path, arguments: list[str], line: str) -> None:
    (place / "improv.toml").write_text("[robots.ada]\n")
    assert line in run("output", "check", *arguments, folder=place).stderr
