"""Who may stop what plays, and what becomes of those that are gone."""

from __future__ import annotations

import socket
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from improv_core.playback.stop_socket import StopSocket, StopSocketError, stop_all


@pytest.fixture(autouse=True)
def runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with a short name: that of a socket has at most 107 bytes."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        yield Path(folder, "improv")


def test_all_that_play_are_stopped() -> None:
    stopped: list[str] = []

    def stop(name: str) -> str:
        stopped.append(name)
        return f"stopped {name}"

    sockets = [StopSocket(lambda: stop("one")), StopSocket(lambda: stop("two"))]
    assert sorted(stop_all()) == ["stopped one", "stopped two"]
    assert sorted(stopped) == ["one", "two"]
    for each in sockets:
        each.close()
    assert list(stop_all()) == []


def test_one_that_is_silent_holds_up_nobody(runtime: Path) -> None:
    made = StopSocket(lambda: "stopped")
    (path,) = runtime.iterdir()
    with socket.socket(socket.AF_UNIX) as silent, socket.socket(socket.AF_UNIX) as hangs:
        silent.connect(str(path))
        hangs.bind(str(runtime / "0-hangs.sock"))
        hangs.listen()
        assert sorted(stop_all()) == ["process 0 does not answer: end it with `kill`", "stopped"]
    made.close()


def test_nobody_else_can_enter(runtime: Path) -> None:
    made = StopSocket(lambda: "stopped")
    (path,) = runtime.iterdir()
    assert runtime.stat().st_mode & 0o777 == 0o700
    assert path.stat().st_mode & 0o777 == 0o600
    made.close()


@pytest.mark.parametrize("trap", ["open to all", "a link"])
def test_a_folder_that_is_not_ours_alone(trap: str, runtime: Path, tmp_path: Path) -> None:
    if trap == "a link":
        runtime.symlink_to(tmp_path)
    else:
        runtime.mkdir()
        runtime.chmod(0o777)
    with pytest.raises(StopSocketError, match="remove it"):
        StopSocket(lambda: "stopped")


def test_one_that_was_killed(runtime: Path) -> None:
    runtime.mkdir(0o700)
    with socket.socket(socket.AF_UNIX) as killed:
        killed.bind(str(runtime / "1-a.sock"))
    assert list(stop_all()) == []
    assert list(runtime.iterdir()) == []


def test_who_asks_for_something_else_stops_nothing(runtime: Path) -> None:
    made = StopSocket(lambda: "stopped")
    (path,) = runtime.iterdir()
    with socket.socket(socket.AF_UNIX) as stranger:
        stranger.connect(str(path))
        stranger.sendall(b"play\n")
        assert stranger.recv(100) == b""
    assert list(stop_all()) == ["stopped"]
    made.close()
    assert list(runtime.iterdir()) == []
