"""The command line: run in the test's own process, or as people run it if a process or a terminal matters."""

from __future__ import annotations

import io
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager, redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
import pytest
from click.testing import CliRunner

from improv_core.commands.main import improv
from improv_core.commands.ros_arguments import without_ros_arguments
from improv_core.ipc.stage_process import Stage
from tests.stage_on_thread import USED, StageOnThread

IMPROV = [sys.executable, "-u", "-m", "improv_core"]
LIMIT = 60.0
"""Seconds to wait for anything on a busy machine."""
EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.improv"))
REACTING = sorted((Path(__file__).parents[2] / "examples" / "senses").glob("*.improv"))
"""Examples in which robots react."""
SQUARE = next(path for path in EXAMPLES if path.name == "square.improv")


SIMULATED = ("--backend", "sim", "--no-browser")
"""Options with which a program plays in the simulator, live."""


def written(folder: Path, text: str, name: str = "dance.improv") -> Path:
    """Write a program with this text to a file."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def program(path: Path, script: str) -> Path:
    """Make a program that runs a shell script."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    return path


@dataclass(frozen=True, slots=True)
class Ended:
    """A command that has ended: its exit code, and its output."""

    returncode: int
    stdout: str
    stderr: str


def run(*arguments: str | Path, env: dict[str, str] | None = None, text: str = "", folder: Path | None = None) -> Ended:
    """Run a command with this text as standard input, in this process."""
    ours, theirs = without_ros_arguments([*map(str, arguments)])
    with chdir(folder or "."), usual_signals(), pytest.MonkeyPatch.context() as patch:
        patch.setattr(USED, StageOnThread)
        ended = CliRunner().invoke(improv, ours, input=text, env=env, obj=theirs, prog_name="improv")
    if ended.exception and not isinstance(ended.exception, SystemExit):
        raise ended.exception
    return Ended(ended.exit_code, ended.stdout_bytes.decode(), ended.stderr_bytes.decode())


@contextmanager
def usual_signals() -> Iterator[None]:
    """Restore the signal handlers after a command, so that Ctrl-C ends the tests."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


class Running:
    """A command that runs on a thread of this process, and its lines, errors too. One at a time."""

    def __init__(self, *arguments: str | Path, stage: type[StageOnThread | Stage] = StageOnThread) -> None:
        self._arguments = [*map(str, arguments)]
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._handlers: dict[int, Callable[..., None]] = {}
        self._codes: list[object] = []
        self._unended = ""
        self._patch = pytest.MonkeyPatch()
        self._patch.setattr(USED, stage)
        self._patch.setattr(signal, "signal", self._here(self._handlers.__setitem__, signal.signal))
        self._patch.setattr(click, "echo", self._here(self._print, click.echo))
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    @property
    def runs(self) -> bool:
        return self._thread.is_alive()

    def wait(self, part: str) -> str:
        """Wait for the next line with `part` in it."""
        while part not in (line := self.next()):
            pass
        return line

    def next(self) -> str:
        """Wait for the next line."""
        return self._lines.get(timeout=LIMIT)

    def interrupt(self) -> None:
        """Interrupt it as Ctrl-C does."""
        self._handlers[signal.SIGINT](signal.SIGINT, None)

    def end(self) -> tuple[object, list[str]]:
        """Wait until it has ended. Return the exit code, and the lines that no test has waited for."""
        try:
            self._thread.join(LIMIT)
            assert not self._thread.is_alive(), "it does not end"
        finally:
            self._patch.undo()
        lines = []
        while not self._lines.empty():
            lines.append(self._lines.get())
        return self._codes[0], lines

    def close(self) -> None:
        """Interrupt it."""
        self.interrupt()
        code, _ = self.end()
        assert code == 130

    def _run(self) -> None:
        try:
            improv(self._arguments, obj="", prog_name="improv")
        except SystemExit as ended:
            self._codes.append(ended.code)

    def _here(self, ours: Callable[..., Any], usual: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that behaves differently on the thread of this command."""

        def call(*arguments: Any, **named: Any) -> Any:
            mine = threading.current_thread() is self._thread
            return (ours if mine else usual)(*arguments, **named)

        return call

    def _print(self, text: str, nl: bool = True, **_: Any) -> None:
        """Keep each line once it is complete. (pytest replaces `sys.stdout` in the middle of a test.)"""
        *lines, self._unended = (self._unended + text + "\n" * nl).split("\n")
        for line in lines:
            self._lines.put(f"{line}\n")


@contextmanager
def playing(*arguments: str | Path) -> Iterator[subprocess.Popen[str]]:
    """Run a command in its own process, and yield it once something plays."""
    command = [*IMPROV, *map(str, arguments), *SIMULATED]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, bufsize=1) as process:
        assert process.stdout
        while not process.stdout.readline().startswith("▶"):
            assert process.poll() is None
        try:
            yield process
        finally:
            process.kill()


def stop_within(folder: str | Path, before: str = "") -> list[str]:
    """Return the command `improv stop` for performances with this XDG_RUNTIME_DIR: others test beside us. The code
    `before` runs first."""
    code = f"""{before}
from pathlib import Path
from improv_core.__main__ import main
from improv_core.safety import stop_socket
stop_socket.RUNTIME = stop_socket.SHARED = Path({str(folder)!r})
main()"""
    return [sys.executable, "-c", code, "stop"]


class Terminal(io.StringIO):
    """A terminal's screen."""

    def isatty(self) -> bool:
        return True


def shown_in_terminal(*arguments: str | Path) -> str:
    """Return a terminal's output from a command, run in this process."""
    with redirect_stdout(Terminal()) as shown, redirect_stderr(shown), suppress(SystemExit):
        improv([*map(str, arguments)], obj="", prog_name="improv")
    return shown.getvalue()
