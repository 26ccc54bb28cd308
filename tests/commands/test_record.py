"""`improv record`, run as people run it."""

from __future__ import annotations

import asyncio
import math
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest

from improv_core.commands.exit_codes import CommandError
from improv_core.commands.record import record_live
from improv_core.commands.terminal import TerminalSession
from improv_core.outputs.recording.recorder import Recorder
from improv_core.session.start import Options
from tests.commands.command_line import IMPROV, LIMIT, SIMULATED, Running, run, written
from tests.open_page import connected, heard, live_behind
from tests.processes import wait_until_written
from tests.recordings import changes, read, read_joints
from tests.stage_on_thread import USED, StageOnThread

FORWARD, STILL = (2.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)


@pytest.fixture
def program(tmp_path: Path) -> Path:
    return written(tmp_path, "beat 60\na b $ forward [left left]\n")


@pytest.fixture
def endless(tmp_path: Path) -> Path:
    return written(tmp_path, "r $ repeat forward\n", "endless.improv")


def start(program: Path, path: Path, *options: str) -> subprocess.Popen[str]:
    command = [*IMPROV, "record", str(program), "-o", str(path), *options]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def test_a_program_is_recorded_at_once(program: Path, tmp_path: Path) -> None:
    path = tmp_path / "dance.mcap"
    before = time.time_ns()
    done = run("record", program, "-o", path)
    assert (done.returncode, done.stderr) == (0, "")
    assert re.fullmatch(rf"{path}: 2 robots, 88 messages, 2\.1 s \(computed in \d+\.\d\d s\)\n", done.stdout)
    messages = read(path)
    start = messages[0].time
    assert before <= start <= time.time_ns()
    assert [(at - start, moving[0]) for at, moving in changes(messages, "/a/cmd_vel")] == [
        (0, 2.0),
        (10**9, 0.0),
        (2 * 10**9, 0.0),
    ]
    assert {each.name for each in tmp_path.iterdir()} == {"dance.improv", "dance.mcap"}


def test_an_endless_program_needs_an_end(endless: Path, tmp_path: Path) -> None:
    path = tmp_path / "endless.mcap"
    done = run("record", endless, "-o", path)
    problem = "this program never ends: limit it, for example with `--for 60` (seconds)"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"improv: {problem}\n")
    assert not path.exists()
    done = run("record", endless, "-o", path, "--for", "60")
    assert (done.returncode, done.stdout.partition(" (")[0]) == (0, f"{path}: 1 robot, 1203 messages, 60.1 s")


@pytest.mark.parametrize("backend", [(), ("--backend", "sim")])
def test_a_wrong_program_is_not_recorded(backend: tuple[str, ...], tmp_path: Path) -> None:
    done = run("record", written(tmp_path, "r $ lft\n"), "-o", tmp_path / "dance.mcap", *backend)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (1, "", 1)
    assert not (tmp_path / "dance.mcap").exists()


def test_a_failure_is_one_line(program: Path, tmp_path: Path) -> None:
    empty = written(tmp_path, "x = left\n", "empty.improv")
    path = tmp_path / "dance.mcap"
    for arguments, problem in [
        ((program, "-o", program), f"{program}: the recording's name must end in .mcap"),
        ((empty, "-o", path), f"no robot got a command: {path} was not written"),
        ((tmp_path / "none.improv", "-o", path), f"{tmp_path / 'none.improv'}: no such file or directory"),
        (
            (program, "-o", path, "--backend", "sim", "--for", "1"),
            "--for cannot be combined with --backend; stop a live run with Ctrl-C",
        ),
        ((program, "-o", path, "--force"), "--force is for robots that are not in their places: it needs --backend"),
    ]:
        done = run("record", *arguments)
        assert (done.returncode, done.stdout) == (2, "")
        assert done.stderr.splitlines()[-1] == f"improv: {problem}"
    assert not path.exists()


def test_terminated_while_it_computes_nothing_is_left(endless: Path, tmp_path: Path) -> None:
    process = start(endless, tmp_path / "x.mcap", "--for", "1e9")
    # Not before something is written: Python's exit code differs if it is interrupted while it imports mcap.
    wait_until_written(process, tmp_path, LIMIT)
    process.send_signal(signal.SIGTERM)
    assert process.communicate(timeout=LIMIT)[1] == f"improv: interrupted: {tmp_path / 'x.mcap'} was not written\n"
    assert process.returncode == 130
    assert list(tmp_path.iterdir()) == [endless]


def test_joints_are_recorded_as_they_are_sent(tmp_path: Path) -> None:
    program, path = tmp_path / "wave.improv", tmp_path / "wave.mcap"
    program.write_text("beat 240\nada is puppet\nada $ head (left right) || forward left\n", encoding="utf-8")
    before = time.time_ns()
    done = run("record", program, "-o", path, *SIMULATED)
    assert (done.returncode, done.stderr) == (0, "")
    yaw = [each.joints["head_yaw"][0] for each in read_joints(path)]
    assert max(yaw) == pytest.approx(math.radians(30))
    assert yaw[-1] == pytest.approx(0.0, abs=1e-9)
    assert all(before < each.time < time.time_ns() for each in read_joints(path))


def test_interrupted_while_it_plays_it_is_complete(endless: Path, tmp_path: Path) -> None:
    path = tmp_path / "endless.mcap"
    recording = Running("record", endless, "-o", path, *SIMULATED)
    asyncio.run(asyncio.wait_for(moved(live_behind(recording.next().split()[-1])), LIMIT))
    recording.interrupt()
    code, said = recording.end()
    assert code == 130
    messages = read(path)
    assert said[-1].startswith(f"{path}: 1 robot, {len(messages)} messages, ")
    assert [moving for _, moving in changes(messages, "/r/cmd_vel")] == [FORWARD, STILL]
    assert [message.velocity for message in messages[-4:]] == [FORWARD, *[STILL] * 3]


async def moved(live: str) -> None:
    """Wait until the page shows that the first robot has moved: by then, it has got a command."""
    async with connected(live) as page:
        await heard(page, lambda told: told["type"] == "poses" and any(x > 0.1 for x, *_ in told["poses"]))


@pytest.mark.parametrize(("launched", "code"), [((), 130), (("--ros-args", "-r", "a:=b"), 0)])
def test_interrupted_before_anything_is_sent_it_is_not_written(
    launched: tuple[str, ...], code: int, program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """For `ros2 launch`, a node that ends with another code than 0 has died."""

    async def interrupted(performing: TerminalSession, *_: object) -> None:
        signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(TerminalSession, "play", interrupted)
    path = tmp_path / "dance.mcap"
    done = run("record", program, "-o", path, *SIMULATED, *launched)
    assert (done.returncode, done.stderr) == (code, f"improv: interrupted: {path} was not written\n")
    assert not path.exists()


def test_a_full_disk_ends_the_dance(endless: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Recorder, "take", fail)
    monkeypatch.setattr(USED, StageOnThread)
    with pytest.raises(CommandError, match=r"x\.mcap was not written: no space left on device"):
        asyncio.run(record_live(endless, tmp_path / "x.mcap", Options("sim"), browser=False))
    assert list(tmp_path.iterdir()) == [endless]
