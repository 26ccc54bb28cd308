"""The users who may stop a performance, and the sockets of processes that are gone."""

from __future__ import annotations

import fcntl
import os
import shutil
import socket
import stat
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from improv_core.safety import stop_server, stop_socket
from improv_core.safety.stage_stops import OBEYED, StageSocket, sockets_of
from improv_core.safety.stop_socket import StopSocket, StopSocketError, fixed_folder, stop_all
from improv_core.safety.stops import Stops

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with a short name: the name of a socket has at most 107 bytes. `SHARED` is beside it."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        monkeypatch.setattr(stop_socket, "RUNTIME", Path(folder, "users"))
        monkeypatch.setattr(stop_socket, "SHARED", Path(folder, "shared"))
        Path(folder, "shared").mkdir()
        yield Path(folder, "improv")


@pytest.fixture
def made(runtime: Path) -> Iterator[StopSocket]:
    """The socket of a process that plays, in its folder."""
    made = StopSocket(lambda _: "stopped")
    yield made
    made.close()


def test_all_playing_processes_are_stopped() -> None:
    stopped: list[str] = []

    def stop(name: str) -> str:
        stopped.append(name)
        return f"stopped {name}"

    sockets = [StopSocket(lambda _: stop("one")), StopSocket(lambda _: stop("two"))]
    assert sorted(stop_all()) == ["stopped one", "stopped two"]
    assert sorted(stopped) == ["one", "two"]
    for each in sockets:
        each.close()
    assert list(stop_all()) == []


@pytest.mark.usefixtures("made")
def test_a_silent_process_delays_nobody(runtime: Path) -> None:
    (path,) = runtime.iterdir()
    with socket.socket(socket.AF_UNIX) as silent, socket.socket(socket.AF_UNIX) as hangs:
        silent.connect(str(path))
        hangs.bind(str(runtime / "0-hangs.sock"))
        hangs.listen()
        assert sorted(stop_all()) == ["process 0 does not answer: end it with `kill`", "stopped"]


@pytest.mark.usefixtures("made")
def test_only_the_user_can_open_the_socket(runtime: Path) -> None:
    (path,) = runtime.iterdir()
    assert runtime.stat().st_mode & 0o777 == 0o700
    assert path.stat().st_mode & 0o777 == 0o600


def test_the_folder_is_locked_while_somebody_listens_so_that_systemd_removes_no_socket(runtime: Path) -> None:
    made = StopSocket(lambda _: "stopped")
    folder = os.open(runtime, os.O_RDONLY)
    with pytest.raises(BlockingIOError):
        fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    made.close()
    fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
    os.close(folder)


@pytest.mark.usefixtures("runtime")
def test_a_socket_that_is_removed_with_its_folder_comes_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stop_server, "LOOK_PERIOD", 0.01)
    made, show = StopSocket(lambda _: "stopped"), fixed_folder() / f"{os.getpid()}-show"
    stage = StageSocket(show, "ros", lambda _, answer: answer(OBEYED))
    shutil.rmtree(fixed_folder())
    shutil.rmtree(os.environ["XDG_RUNTIME_DIR"] + "/improv")
    end = time.monotonic() + 30
    while list(stop_all()) != ["stopped"] or not sockets_of(show):
        assert time.monotonic() < end
    assert stat.S_IMODE(fixed_folder().stat().st_mode) == 0o700
    made.close()
    stage.close()
    assert list(stop_all()) == []


@pytest.mark.parametrize("trap", ["open to all", "a link", "a file"])
def test_a_folder_that_others_can_use_is_not_used(trap: str, runtime: Path, tmp_path: Path) -> None:
    folder = stop_socket.SHARED / f"improv-{os.getuid()}"
    for each in (runtime, folder):
        if trap == "a link":
            each.symlink_to(tmp_path)
        elif trap == "a file":
            each.touch()
        else:
            each.mkdir()
            each.chmod(0o777)
    made = StopSocket(lambda _: "stopped")
    assert list(tmp_path.iterdir()) == []
    assert fixed_folder() == fixed_folder() != folder
    assert list(stop_all()) == ["stopped"]
    made.close()


@pytest.mark.usefixtures("made")
@pytest.mark.parametrize("environment", ["unset", "another", "removed", "not a folder"])
def test_the_socket_is_found_in_any_environment(
    environment: str, runtime: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if environment == "unset":
        monkeypatch.delenv("XDG_RUNTIME_DIR")
    elif environment == "removed":
        shutil.rmtree(runtime)
    else:
        monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path if environment == "another" else "/dev/null"))
    assert list(stop_all()) == ["stopped"]


def test_without_any_folder_it_fails_with_one_line() -> None:
    stop_socket.SHARED.rmdir()
    with pytest.raises(StopSocketError, match="shared: No such file or directory"):
        StopSocket(lambda _: "stopped")


@pytest.mark.skipif(os.getuid() != 0, reason="needs root, to be other users")
@pytest.mark.parametrize("taken", [False, True])
def test_sudo_stops_its_callers_robots(taken: bool) -> None:
    """With real processes and folders: the user is one that exists only here."""
    user = 200_000 + os.getpid() * 2 + taken
    usual = Path(f"/tmp/improv-{user}")
    if taken:  # by another user
        usual.mkdir(0o777)
    imports = "import os, improv_core.safety.stop_server, improv_core.safety.stop_socket as s"
    become = f"{imports}; os.setgroups([]); os.setuid({user})"
    code = f"{become}; reached = s.StopSocket(lambda _: 'stopped it'); print(flush=True); input()"
    plays = subprocess.Popen([sys.executable, "-c", code], env={}, stdin=-1, stdout=-1, text=True, cwd=ROOT)
    assert plays.stdin
    assert plays.stdout
    assert plays.stdout.readline() == "\n"
    made = [each for each in Path("/tmp").glob(f"improv-{user}*") if each.stat().st_uid == user]
    try:
        others = "import improv_core.safety.stop_socket as s; f = s._users; s._users = lambda: [*f()][1:]"
        for begin, env in ((become, {}), (others, {"SUDO_UID": str(user)})):  # root's are those of other tests
            command = [sys.executable, "-c", f"{begin}; print(*s.stop_all())"]
            done = subprocess.run(command, env=env, text=True, capture_output=True, cwd=ROOT)
            assert (done.stdout, done.stderr) == ("stopped it\n", "")
    finally:
        plays.communicate("\n")
        for each in (*made, usual):
            shutil.rmtree(each, ignore_errors=True)


def test_the_socket_of_a_process_that_was_killed_is_removed(runtime: Path) -> None:
    runtime.mkdir(0o700)
    with socket.socket(socket.AF_UNIX) as killed:
        killed.bind(str(runtime / "1-a.sock"))
    assert list(stop_all()) == []
    assert list(runtime.iterdir()) == []


@pytest.mark.parametrize(
    ("note", "counts"),
    [
        ("{boot} {after}", True),
        ("{boot} {before}", False),
        ("{boot} {future}", False),
        ("other {after}", False),
        ("", False),
        ("{boot}", False),
        ("{boot} soon", False),
    ],
)
def test_a_stop_counts_for_processes_that_started_before_it(note: str, counts: bool) -> None:
    now = time.monotonic()
    times = {"before": now - 2, "after": now - 1, "future": now + 1000}
    (fixed_folder() / stop_socket.NOTE).write_text(note.format(boot=stop_socket._boot(), **times))
    assert stop_socket.stopped_since(now - 1.5) == counts


def test_a_process_reads_the_note_only_once_it_listens() -> None:
    """Otherwise a stop between the two would be lost."""
    stops, started = Stops(), time.monotonic()
    assert list(stop_all()) == []
    made = stop_socket.listening(lambda _: "stopped", stops, started)
    assert made
    assert stops.count == 1
    assert list(stop_all()) == ["stopped"]
    made.close()


def test_any_other_request_stops_nothing(runtime: Path, made: StopSocket) -> None:
    (path,) = runtime.iterdir()
    with socket.socket(socket.AF_UNIX) as stranger:
        stranger.connect(str(path))
        stranger.sendall(b"play\n")
        assert stranger.recv(100) == b""
    assert list(stop_all()) == ["stopped"]
    made.close()
    assert list(runtime.iterdir()) == []


def test_a_socket_survives_running_out_of_handles_or_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    failing = [OSError(24, "too many open files"), RuntimeError("can't start new thread")]
    accept, begin = socket.socket.accept, threading.Thread.start

    def accept_later(self: socket.socket) -> tuple[socket.socket, object]:
        if failing and isinstance(failing[0], OSError):
            raise failing.pop(0)
        return accept(self)

    def start(self: threading.Thread) -> None:
        if "_answer" in self.name and failing:
            raise failing.pop(0)
        begin(self)

    monkeypatch.setattr(socket.socket, "accept", accept_later)
    monkeypatch.setattr(threading.Thread, "start", start)
    made = StopSocket(lambda _: "stopped")
    assert [list(stop_all()), list(stop_all())] == [["stopped"], ["stopped"]]
    assert failing == []
    made.close()
