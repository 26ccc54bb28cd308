"""`improv play`, run as people run it, live and `--fast`."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import partial
from io import BufferedReader
from pathlib import Path

import pytest

from improv_core.commands import terminal
from improv_core.commands.exit_codes import FAILED, INTERRUPTED
from improv_core.commands.playing import play
from improv_core.ipc.stage_process import HearStage
from improv_core.program.analysis import analyze
from improv_core.protocol.messages import State, ToStage
from improv_core.safety.stops import Stops
from improv_core.session.session import Playback
from improv_core.session.start import Options
from improv_core.session.state import Output
from tests.commands.command_line import IMPROV, LIMIT, SIMULATED, SQUARE, Ended, playing, run, written
from tests.session.fakes import Fake


@pytest.mark.parametrize(
    ("told", "pressed", "code"),
    [
        (["playing", "ended"], [], 0),
        (["playing", "stopped"], [], FAILED),  # because of a fault, or since the stage was too late
        (["playing", "stopped"], ["/e_stop"], INTERRUPTED),
    ],
)
def test_the_exit_code_tells_how_it_ended(
    told: list[State], pressed: list[str], code: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stage can stop by itself, without a person's stop."""

    class Robots(Fake):
        def send(self, message: ToStage) -> None:
            super().send(message)
            if message["type"] == "load":
                asyncio.get_running_loop().call_soon(self.perform)

        def perform(self) -> None:
            if pressed:
                self.say({"type": "pressed", "topics": pressed, "count": 1})
            for state in told:
                self.tell(state, 1.0)

    async def start(sink: Output, options: Options, token: str, hear: HearStage, stops: Stops) -> Robots:
        return Robots(sink, options, hear, stops)

    monkeypatch.setattr(terminal, "Playback", partial(Playback, start=start))
    analysis = analyze("beat 60\nr $ forward 8")
    played = play(analysis, tmp_path / "dance.improv", Options("ros"), browser=False)
    assert asyncio.run(played) == code


@pytest.mark.parametrize("allowed", [False, True])
def test_osc_reaches_other_machines_only_if_somebody_allows_it(tmp_path: Path, allowed: bool) -> None:
    program = written(tmp_path, "beat 600\nr $ forward\n")
    (tmp_path / "improv.toml").write_text('[osc]\nlisten = 7000\nhost = "0.0.0.0"\nsend = ["192.0.2.1:9000"]\n')
    options = ["--osc-network"] if allowed else []
    done = run("play", program, *SIMULATED, *options)
    assert done.returncode == 0
    assert ("OSC is off: 0.0.0.0:7000 in improv.toml reaches other machines" in done.stderr) != allowed


def test_play_needs_no_standard_input(tmp_path: Path) -> None:
    program = written(tmp_path, "beat 600\nr $ forward\n")
    command = [*IMPROV, "play", str(program), *SIMULATED]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LIMIT, preexec_fn=lambda: os.close(0))
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--fast"], "this program never ends: limit it, for example with `--for 60` (seconds)"),
        (["--fast", "--for", "nan"], "'nan' is no number."),
        (["--fast", "--for", "0"], "0.0 is not in the range 0<x<=1000000000000.0."),
        (["--fast", "--backend", "ros"], "--fast works only in the simulator: real robots can't be sped up"),
        (["--fast", "--armed"], "--fast begins at once"),
        (["--fast", "--at", "20:15"], "--fast begins at once"),
        (["--fast", "--count-in"], "--fast begins at once"),
        (["--at", "soon"], "'soon' is no time: write 20:15, or 2026-11-24T20:15:00+01:00"),
        (["--at", "2020-01-01T20:15"], "2020-01-01T20:15 has passed: it is 2"),
    ],
)
def test_impossible_options_are_refused(tmp_path: Path, options: list[str], says: str) -> None:
    done = run("play", written(tmp_path, "r $ repeat forward\n"), *options)
    assert (done.returncode, done.stdout) == (2, "")
    assert says in done.stderr


def test_play_of_a_wrong_program_says_why(broken: Path) -> None:
    done = run("play", broken, "--no-browser")
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 2


def test_play_says_in_one_line_why_it_can_not(tmp_path: Path) -> None:
    missing = run("play", tmp_path / "none.improv")
    assert (missing.returncode, missing.stderr.count("\n")) == (2, 1)

    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        busy = run("play", SQUARE, *SIMULATED, "--port", str(port))
    assert busy.returncode == 2
    assert busy.stderr == f"improv: the page's port {port} is taken: choose another, or 0 for any free one\n"

    without = run("play", SQUARE, "--backend", "ros", env={"IMPROV_ROS_PYTHON": sys.executable})
    assert without.returncode == 2
    assert without.stderr.startswith(f"improv: {sys.executable} cannot import rclpy ")
    assert without.stderr.count("\n") == 1


def test_interrupt_stops_the_robots_and_ends(tmp_path: Path) -> None:
    with playing("play", written(tmp_path, "r $ repeat forward\n")) as process:
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=LIMIT)
        assert (process.returncode, errors) == (130, "")


def check(
    folder: Path, program: str, robots: Mapping[str, tuple[float, float]], *options: str, toml: str = ""
) -> Ended:
    """Play a program and compare the end poses of its robots, x and y in meters."""
    (folder / "dance.improv").write_text(program)
    if toml:
        (folder / "improv.toml").write_text(toml)
    done = run("play", "--fast", folder / "dance.improv", "--report", "json", *options)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert {name: (pose["x"], pose["y"]) for name, pose in report["robots"].items()} == {
        name: pytest.approx(place, abs=0.01) for name, place in robots.items()
    }
    return done


def test_an_endless_dance_plays_for_the_given_seconds(tmp_path: Path) -> None:
    done = check(tmp_path, "r $ repeat forward\n", {"r": (7, 0)}, "--for", "3.5")
    assert json.loads(done.stdout)["seconds"] == 3.5


def test_a_bump_at_the_very_end_is_reported(tmp_path: Path) -> None:
    toml = "[world]\nwalls = [[2.2, -1, 2.2, 1]]\n"
    assert "a bumped" in check(tmp_path, "a $ forward\n", {"a": (1.9, 0)}, toml=toml).stderr


def test_motors_are_told_of_once_they_stand(tmp_path: Path) -> None:
    toml = '[profiles.base]\nstep = 1\ndynamics = "motors"\n[robots.a]\nprofile = "base"\n'
    # At 1 m/s² the distance lost while speeding up is missing at the end of the beat; braking makes up for it.
    check(tmp_path, "a $ forward\n", {"a": (1, 0)}, toml=toml)


def test_ctrl_c_ends_it(tmp_path: Path) -> None:
    path = written(tmp_path, "a $ repeat [forward left]\n")
    (tmp_path / "improv.toml").write_text("[world]\nsize = [2, 2]\n")
    command = [*IMPROV, "play", "--fast", str(path), "--for", "1e9"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr
        assert process.stderr.readline().startswith("improv: a bumped")
        process.send_signal(signal.SIGINT)
        assert process.wait(LIMIT) == -signal.SIGINT  # 130 for a shell


def test_the_report_says_how_near_robots_came(tmp_path: Path) -> None:
    program = written(tmp_path, "beat 120\nada at 0 0\nbo at 2 0.8\ncy at 2 -3\nada $ forward forward\nbo $ rest\n")
    done = run("play", "--fast", "--report", "json", program)
    (near,) = json.loads(done.stdout)["near"]
    assert near["robots"] == ["ada", "bo"]
    assert near["ideal"] == pytest.approx({"distance": 0.8, "beat": 1, "seconds": 0.5}, abs=0.01)
    assert "measured" not in near


SCENES = """beat 600
anna bert at line 2
--- walk
anna $ forward left
--- bow
bert $ forward
--- home
anna $ forward
"""


@pytest.mark.parametrize(
    ("options", "start", "end", "seconds"),
    [
        ([], (0, 1), (2, 3), 0.4),
        (["--from", "home"], (2, 1), (2, 3), 0.1),
        (["--only", "walk"], (0, 1), (2, 1), 0.2),
        (["--from", "bow", "--to", "home"], (2, 1), (2, 3), 0.2),
        (["--to", "bow"], (0, 1), (2, 1), 0.3),
    ],
)
def test_scenes_play_alone_from_where_robots_are_when_they_begin(
    tmp_path: Path, options: list[str], start: tuple[float, float], end: tuple[float, float], seconds: float
) -> None:
    (tmp_path / "dance.improv").write_text(SCENES)
    for way in (SIMULATED, ["--fast"]):
        done = run("play", tmp_path / "dance.improv", *way, "--report", "json", *options)
        assert done.returncode == 0, done.stderr
        report = json.loads(done.stdout.splitlines()[-1])
        places = [(report[when]["anna"]["x"], report[when]["anna"]["y"]) for when in ("start", "robots")]
        assert places == [pytest.approx(start), pytest.approx(end)]
        assert report["seconds"] == pytest.approx(seconds)


def test_scenes_that_can_not_be_played_are_refused(tmp_path: Path) -> None:
    (tmp_path / "dance.improv").write_text(SCENES)
    for way in (SIMULATED, ["--fast"]):
        done = run("play", tmp_path / "dance.improv", *way, "--from", "hom")
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    done = run("play", tmp_path / "dance.improv", "--only", "bow", "--to", "home")
    assert (done.returncode, done.stderr) == (2, "improv: --only plays one scene: leave out --from and --to\n")


@pytest.mark.slow("processes play")
@pytest.mark.parametrize("ends", [os.pipe, os.openpty, lambda: [each.detach() for each in socket.socketpair()]])
def test_robots_stop_once_nobody_reads_the_lines_any_more(ends: Callable[[], tuple[int, int]], tmp_path: Path) -> None:
    """If `ros2 launch` is killed, for example: nothing has to be printed then, and no signal comes."""
    with launched(tmp_path, "r $ repeat forward\n", *ends()) as (process, lines):
        while not lines.readline().startswith("▶".encode()):
            assert process.poll() is None
        lines.close()
        process.wait(LIMIT)


@contextmanager
def launched(
    folder: Path, program: str, reader: int, writer: int
) -> Iterator[tuple[subprocess.Popen[bytes], BufferedReader]]:
    """Run a program as `ros2 launch` does, and yield its process and the end of its output."""
    command = [*IMPROV, "play", str(written(folder, program)), *SIMULATED, "--ros-args"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=writer, stderr=writer) as process:
        os.close(writer)
        try:
            with os.fdopen(reader, "rb") as lines:
                yield process, lines
        finally:
            process.kill()


@pytest.mark.slow("processes play")
@pytest.mark.parametrize("stops", [False, True])
def test_ros2_launch_finds_that_it_ends_well_and_prints_whole_lines(stops: bool, tmp_path: Path) -> None:
    """Its `emulate_tty` has output look like a terminal, and any exit code except 0 means to it that a node has
    died."""
    said = b""
    program = f"beat 240\nr $ {'repeat ' * stops}forward\n"
    with launched(tmp_path, program, *os.openpty()) as (process, lines):
        with suppress(OSError):  # EIO, once it has ended
            while line := lines.readline():
                said += line
                if stops and "▶".encode() in line:
                    process.send_signal(signal.SIGINT)
        assert process.wait(LIMIT) == 0
    assert b"\x1b" not in said
    assert said.count(b"\r") == said.count(b"\r\n")
