"""`improv stop`: every performance of this user stops, in any terminal or editor."""

from __future__ import annotations

import asyncio
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import pytest

from improv_core.commands.doctor import stopping
from improv_core.ipc.stage_process import HearStage, Stage
from improv_core.safety import stop_socket
from improv_core.safety.stop_socket import IDLE, stop_all
from improv_core.safety.stops import Stops
from improv_core.storage import saves
from improv_core.storage.saves import Saved
from tests.commands.command_line import LIMIT, SIMULATED, Running, playing, run, written
from tests.ls.client import QUIET, Client, place
from tests.stage_on_thread import StageOnThread

URI = "file:///editor.improv"
LINE = "improv: stopped by `improv stop`\n"
NOTHING = "nothing is playing, and no command that is still starting will play"


@pytest.fixture(autouse=True)
def runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with a short name: that of a socket has at most 107 bytes."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        for name in ("RUNTIME", "SHARED"):  # in this process, but not in others: other tests run beside this one
            monkeypatch.setattr(stop_socket, name, Path(folder))
        monkeypatch.setattr(stop_socket, "LIMIT", LIMIT)
        yield Path(folder, "improv")


@pytest.fixture
def program(tmp_path: Path) -> Path:
    return written(tmp_path, "r $ repeat forward\n")


@pytest.fixture
def watch(program: Path) -> Iterator[Running]:
    watch = Running("watch", program, *SIMULATED)
    watch.wait("▶ r")
    yield watch
    watch.close()


def check(*lines: str, code: int = 0) -> None:
    """Compare the output of `improv stop`, in any order."""
    done = run("stop")
    assert (sorted((done.stdout + done.stderr).splitlines()), done.returncode) == (sorted(lines), code)


def test_a_terminal_a_watched_file_and_an_editor(program: Path, watch: Running) -> None:
    other = written(program.parent, "r $ repeat left\n", "other.improv")
    with playing("play", other) as play, Client(QUIET) as client:
        client.play(URI, "r $ repeat left\n")
        check(*(f"stopped {name}.improv on simulator" for name in ("dance", "editor", "other")))
        client.wait_for_line("stopped by `improv stop`")
        assert play.communicate(timeout=LIMIT)[1] == LINE
        assert play.returncode == 130
        check(NOTHING)
        client.save(URI)
        while "▶" not in client.wait_for_line(""):
            client.save(URI)  # a stop that settles late is repeated, and counts again
    watch.wait(LINE)
    program.write_text("r $ right\n")
    watch.wait("▶ r 1 beat")


def test_a_save_that_is_older_than_the_stop(program: Path, watch: Running, monkeypatch: pytest.MonkeyPatch) -> None:
    stopped = threading.Event()

    async def settle(path: Path, before: Saved) -> Saved:
        await asyncio.to_thread(stopped.wait, LIMIT)
        return await saves.settle(path, before)

    monkeypatch.setattr("improv_core.commands.watching.settle", settle)
    program.write_text("s $ repeat forward\n")
    assert list(stop_all()) == ["stopped dance.improv on simulator"]
    stopped.set()
    watch.wait(LINE)
    assert watch.next() == "■ dance.improv was stopped before it began\n"
    for _ in range(2):
        program.write_text("s $ repeat forward\n")
        assert watch.next().startswith("▶ s")


def test_a_change_of_the_robots_starts_no_stopped_dance(program: Path, watch: Running) -> None:
    assert list(stop_all()) == ["stopped dance.improv on simulator"]
    watch.wait(LINE)
    program.with_name("improv.toml").write_text("[robots.r]\n")
    assert watch.next() == "improv.toml has changed: save dance.improv to play again\n"
    program.write_text("r $ repeat left\n")
    assert watch.next().startswith("▶")


class Stopped(StageOnThread):
    """A stage that somebody stops while it starts."""

    answers: Sequence[str] = ()

    @classmethod
    async def start(
        cls, command: Sequence[str], env: Mapping[str, str], hear: HearStage, stops: Stops
    ) -> StageOnThread | Stage:
        cls.answers = await asyncio.to_thread(list, stop_all())
        return await super().start(command, env, hear, stops)


def test_a_dance_that_has_not_begun(program: Path) -> None:
    code, said = Running("play", program, *SIMULATED, stage=Stopped).end()
    assert (code, said[2:]) == (130, ["■ dance.improv was stopped before it began\n"])
    assert Stopped.answers == ["stopped dance.improv before it began"]


def test_a_program_with_errors_is_not_about_to_begin(program: Path) -> None:
    program.write_text("r $ forwrd\n")
    watch = Running("watch", program, *SIMULATED)
    watch.wait("✗")
    assert list(stop_all()) == [IDLE]
    watch.close()


def test_a_page_on_which_nothing_is_to_play_yet(program: Path) -> None:
    edit = Running("edit", program, *SIMULATED, stage=Stopped)
    edit.wait("editing dance.improv")
    assert Stopped.answers == [IDLE]
    edit.close()


@pytest.mark.slow("starts a process")
@pytest.mark.parametrize(("command", "code"), [("play", 130), ("watch", None)])
def test_a_command_that_has_only_just_been_started(
    command: str, code: int | None, program: Path, runtime: Path
) -> None:
    """Before it listens, `improv stop` can't find it."""
    slow = f"""
import improv_core
print("starts", flush=True)
input()
from pathlib import Path
from improv_core.__main__ import main
from improv_core.safety import stop_socket
stop_socket.RUNTIME = stop_socket.SHARED = Path({str(runtime.parent)!r})
main()"""
    arguments = [sys.executable, "-c", slow, command, str(program), *SIMULATED]
    with subprocess.Popen(arguments, stdin=-1, stdout=-1, text=True, bufsize=1) as starting:
        assert starting.stdin
        assert starting.stdout
        assert starting.stdout.readline() == "starts\n"
        check(NOTHING)
        print(file=starting.stdin)
        assert "■ dance.improv was stopped before it began\n" in iter(starting.stdout.readline, "")
        if code is None:
            program.write_text("r $ repeat left\n")
            assert any(line.startswith("▶ r") for line in iter(starting.stdout.readline, ""))
            starting.terminate()
        assert starting.wait(LIMIT) == (130 if code is None else code)


def test_a_command_that_is_started_after_a_stop_plays(program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    check(NOTHING)
    monkeypatch.setattr("improv_core.commands.terminal.STARTED", time.monotonic())
    play = Running("play", program, *SIMULATED)
    play.wait("▶ r")
    play.close()


def test_a_server_is_reached_before_it_plays_anything(runtime: Path) -> None:
    with Client(QUIET) as client:
        client.open(URI, "r $ repeat left\n")
        client.request("textDocument/hover", place(URI, 0, 0))
        assert list(stop_all()) == [IDLE]
        client.save(URI)
        client.wait_for_line("▶")
        assert list(stop_all()) == ["stopped editor.improv on simulator"]
        client.wait_for_line("stopped by `improv stop`")
    assert list(runtime.iterdir()) == []


def test_a_socket_that_can_not_be_made_keeps_only_real_robots_from_playing(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stop_socket, "SHARED", tmp_path / "missing")
    play = Running("play", program, *SIMULATED)
    why = f"{tmp_path / 'missing'}: No such file or directory"
    assert play.next() == f"improv: `improv stop` won't work: its socket can't be made: {why}\n"
    play.wait("▶")
    play.close()


def test_one_that_does_not_answer_is_a_failure(runtime: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stop_socket, "LIMIT", 0.1)
    runtime.mkdir(mode=0o700)
    with socket.socket(socket.AF_UNIX) as hangs:
        hangs.bind(str(runtime / "7-hangs.sock"))
        hangs.listen()
        check("process 7 does not answer: end it with `kill`", code=1)


def test_doctor_names_its_folder(runtime: Path) -> None:
    assert str(stopping()) == f"✓ `improv stop` works through {runtime.parent / f'improv-{os.getuid()}'}"
    assert list(runtime.iterdir()) == []


def test_stop_reports_a_system_without_unix_sockets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stop_socket, "SUPPORTED", False)
    check("improv: `improv stop` does not work here: this system has no Unix sockets", code=2)
