"""`improv watch`: plays at every save, however an editor saves."""

from __future__ import annotations

import queue
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

LIMIT = 30.0


class Watch:
    """A running `improv watch`, and the lines it prints."""

    def __init__(self, path: Path) -> None:
        command = [sys.executable, "-m", "improv_core", "watch", str(path), "--backend", "sim", "--no-browser"]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()

    def wait(self, part: str) -> str:
        """The next line with `part` in it."""
        while part not in (line := self._lines.get(timeout=LIMIT)):
            pass
        return line

    def close(self) -> None:
        self._process.terminate()
        assert self._process.wait(LIMIT) == 130

    def _read(self) -> None:
        assert self._process.stdout
        for line in self._process.stdout:
            self._lines.put(line)


@pytest.fixture
def program(tmp_path: Path) -> Path:
    path = tmp_path / "dance.improv"
    path.write_text("r $ repeat forward\n")
    return path


@pytest.fixture
def watch(program: Path) -> Iterator[Watch]:
    watch = Watch(program)
    watch.wait("▶ r ∞")
    yield watch
    watch.close()


def test_written_in_place(watch: Watch, program: Path) -> None:
    program.write_text("r $ left\n")
    watch.wait("▶ r 1 beat")


def test_replaced_by_rename(watch: Watch, program: Path) -> None:
    for beats in ("2", "3"):
        new = program.with_suffix(".new")
        new.write_text(f"r $ repeat {beats} left\n")
        new.rename(program)
        watch.wait(f"▶ r {beats} beats")


def test_a_wrong_save_is_told_as_check_tells_it(watch: Watch, program: Path) -> None:
    program.write_text("r $ lft\n")
    assert watch.wait("error").endswith(":1:5: error[unknown-name] `lft` is not known: did you mean `left`?\n")
    program.write_text("r $ left left\n")
    watch.wait("▶ r 2 beats")
