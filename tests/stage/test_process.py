"""The stage as a process: what it says, and that it ends cleanly however it is ended."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest

from improv_core import stage
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.score_json import to_json

LIMIT = 30


class Process:
    """A stage with the simulator, spoken to as its parent does."""

    def __init__(self, env: Mapping[str, str] = MappingProxyType({})) -> None:
        folder = Path(stage.__file__).parent
        command = [sys.executable, str(folder), "--sink", "simulator"]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe, env={**os.environ, **env})
        ready = self.wait("ready")
        assert ready["protocol"] == 1
        self.page: str = ready["page"]

    def write(self, line: bytes) -> None:
        assert self.process.stdin
        self.process.stdin.write(line)
        self.process.stdin.flush()

    def play(self, program: str) -> None:
        score = to_json(score_of(analyze(program)))
        message = {"type": "load", "generation": 1, "score": score, "when": "restart", "backend": "simulator"}
        self.write(json.dumps(message).encode() + b"\n")
        assert self.wait("transport")["state"] == "playing"

    def wait(self, kind: str) -> dict[str, Any]:
        """The next message of a type."""
        assert self.process.stdout
        for line in self.process.stdout:
            message: dict[str, Any] = json.loads(line)
            if message["type"] == kind:
                return message
        raise AssertionError(f"the stage ended before it said {kind}")

    def ends(self) -> None:
        """It says that it stopped the robots, ends with code 0, and has nothing to complain about."""
        assert self.wait("transport")["state"] == "stopped"
        self.wait("stopped")
        assert self.process.stderr
        assert self.process.stderr.read() == b""
        assert self.process.wait(LIMIT) == 0


@pytest.fixture
def process() -> Iterator[Process]:
    process = Process()
    process.play("r $ repeat forward\n")
    yield process
    process.process.kill()
    process.process.wait(LIMIT)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_signals_stop_the_robots_first(process: Process, number: signal.Signals) -> None:
    process.process.send_signal(number)
    process.ends()


def test_end_of_input_in_the_middle_of_a_line(process: Process) -> None:
    process.write(b'{"type": "load", "gener')
    assert process.process.stdin
    process.process.stdin.close()
    process.ends()


def test_what_it_does_not_understand_it_says_and_plays_on(process: Process) -> None:
    process.write(b"no JSON\n[1]\n" + b'{"type": "dance"}\n{"type": "load", "generation": 2, "score": {}}\n')
    for part in ("not JSON", "not a message", "`dance`", "`load` needs"):
        assert part in process.wait("error")["message"]
    process.write(b'{"type": "ping", "number": 1}\n')
    process.wait("pong")
    process.write(b'{"type": "hush"}\n')
    assert process.wait("transport")["state"] == "stopped"
