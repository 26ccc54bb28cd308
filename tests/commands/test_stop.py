"""`improv stop`: whatever plays, in any terminal or editor of this user, stops."""

from __future__ import annotations

import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from improv_core.commands.doctor import stopping
from improv_core.playback.stop_socket import IDLE, StopSocket, stop_all
from tests.commands.command_line import IMPROV, LIMIT, run
from tests.commands.test_watch import Watch
from tests.ls.client import Client

URI = "file:///editor.improv"
LINE = "improv: stopped by `improv stop`\n"


@pytest.fixture(autouse=True)
def runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with a short name: that of a socket has at most 107 bytes."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        yield Path(folder, "improv")


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "dance.improv"
    path.write_text("r $ repeat forward\n")
    return path


def check(*lines: str, code: int = 0) -> None:
    """What `improv stop` prints, in whatever order."""
    done = run("stop")
    assert (sorted((done.stdout + done.stderr).splitlines()), done.returncode) == (sorted(lines), code)


def playing(path: Path) -> subprocess.Popen[str]:
    """A running `improv play`, once it plays."""
    command = [*IMPROV, "play", str(path), "--backend", "sim", "--no-browser"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1)
    assert process.stdout
    while not process.stdout.readline().startswith("▶"):
        assert process.poll() is None
    return process


def test_nothing_is_playing() -> None:
    check("nothing is playing")


def test_a_terminal_a_watched_file_and_an_editor(program: Path) -> None:
    watched = program.with_name("watched.improv")
    watched.write_text("r $ repeat left\n")
    play, watch = playing(program), Watch(watched)
    watch.wait("▶")
    with Client({"backend": "sim", "page": {"open": False}}) as client:
        client.open(URI, "r $ repeat left\n")
        client.save(URI)
        client.wait_for_line("▶")
        check(*(f"stopped {name}.improv on simulator" for name in ("dance", "editor", "watched")))
        client.wait_for_line("stopped by `improv stop`")
        check("nothing is playing")
        client.save(URI)
        client.wait_for_line("▶")
    _, errors = play.communicate(timeout=LIMIT)
    assert (errors, play.returncode) == (LINE, 130)
    watch.wait(LINE)
    watched.write_text("r $ right\n")
    watch.wait("▶ r 1 beat")
    watch.close()


def test_a_save_that_is_older_than_the_stop(program: Path) -> None:
    watch = Watch(program)
    watch.wait("▶")
    program.write_text("s $ repeat forward")  # without the end of its line, it is played half a second later
    assert list(stop_all()) == ["stopped dance.improv on simulator"]
    watch.wait(LINE)
    watch.wait("■ dance.improv was stopped before it began")
    program.write_text("s $ repeat forward\n")
    watch.wait("▶ s")
    watch.close()


def test_a_dance_that_has_not_begun(program: Path, runtime: Path) -> None:
    command = [*IMPROV, "play", str(program), "--backend", "sim", "--no-browser"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    while not list(runtime.glob("*.sock")):
        assert process.poll() is None
    (answer,) = stop_all()
    said, errors = process.communicate(timeout=LIMIT)
    assert process.returncode == 130
    assert "▶" not in said
    assert errors in ("", LINE)
    assert answer in (IDLE, "stopped dance.improv before it began", "stopped dance.improv on simulator")


def test_one_that_was_killed_and_one_that_hangs(program: Path, runtime: Path) -> None:
    killed, halted, play = playing(program), playing(program), playing(program)
    killed.kill()
    killed.wait(LIMIT)
    halted.send_signal(signal.SIGSTOP)
    assert len(list(runtime.iterdir())) == 3
    check("stopped dance.improv on simulator", f"process {halted.pid} does not answer: end it with `kill`")
    assert play.wait(LIMIT) == 130
    halted.kill()
    for process in (killed, halted, play):
        process.communicate(timeout=LIMIT)


def test_a_socket_that_can_not_be_made_is_no_reason_not_to_play(program: Path, runtime: Path) -> None:
    runtime.mkdir()
    runtime.chmod(0o755)
    play = playing(program)
    play.send_signal(signal.SIGINT)
    _, errors = play.communicate(timeout=LIMIT)
    why = f"{runtime} must be a folder that only you can access: remove it"
    assert errors == f"improv: `improv stop` won't work, because its socket can't be made: {why}\n"
    check(f"improv: `improv stop` does not work here: {why}", code=2)
    assert str(stopping()) == f"✗ `improv stop` does not work: {why}"


def test_names_with_escape_codes(runtime: Path) -> None:
    made = StopSocket(lambda: "stopped \x1b]0;x\x07.improv")
    check(r"stopped \x1b]0;x\x07.improv")
    made.close()


def test_doctor_tells_where_it_works(runtime: Path) -> None:
    assert str(stopping()) == f"✓ `improv stop` works through {runtime}"
    assert list(runtime.iterdir()) == []


def test_a_system_without_unix_sockets() -> None:
    code = "import socket; del socket.AF_UNIX; from improv_core.__main__ import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code, "stop"], capture_output=True, text=True, timeout=LIMIT, check=False
    )
    assert done.stderr == "improv: `improv stop` does not work here: this system has no Unix sockets\n"
