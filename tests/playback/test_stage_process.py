"""The stage as a process: what it says, and that it ends cleanly however it is ended."""

from __future__ import annotations

import json
import queue
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from threading import Timer
from typing import Any

import pytest

from improv_core import stage
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.score import to_json
from improv_core.stage.__main__ import Arrival, End, Play, Reading, _Opened, _play
from improv_core.stage.protocol import SILENCE_LIMIT, FromStage, Load, Ready
from tests.stage.test_player import Memory

LIMIT = 30


class Process:
    """A stage with the simulator, spoken to as its parent does."""

    def __init__(self) -> None:
        folder = Path(stage.__file__).parent
        command = [sys.executable, str(folder), "--sink", "simulator"]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe)
        assert self.wait("ready")["protocol"] == 1

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


def perform(sink: Memory, inbox: queue.SimpleQueue[Arrival], program: str) -> list[FromStage]:
    """What a stage with real robots says from a program on until the inbox has `end`."""
    sink.live = True
    told: list[FromStage] = []
    inbox.put({"type": "ping", "number": 1})
    load: Load = {"type": "load", "generation": 1, "score": {}, "when": "restart", "backend": "memory"}
    inbox.put(Play(load, score_of(analyze(program))))
    ready: Ready = {"type": "ready", "protocol": 1, "sink": "memory", "live": True}
    _play(_Opened(sink, ready, told.append), inbox)
    return told


def test_who_ends_while_listeners_are_waited_for_never_begins() -> None:
    sink = Memory()
    sink.deaf = {"r": "nobody listens"}
    inbox: queue.SimpleQueue[Arrival] = queue.SimpleQueue()
    Timer(0.1, inbox.put, [End()]).start()
    Timer(0.2, sink.deaf.clear).start()
    told = perform(sink, inbox, "r $ forward\n")
    assert told[-1]["type"] == "stopped"
    assert not any(twist.x for _, _, twist in sink.sent)


@pytest.mark.parametrize("reads", [False, True])
def test_a_parent_that_is_silent_because_we_read_is_not_hung(reads: bool) -> None:
    inbox: queue.SimpleQueue[Arrival] = queue.SimpleQueue()
    if reads:
        Timer(0.1, inbox.put, [Reading()]).start()
    Timer(0.1 + 2 * SILENCE_LIMIT, inbox.put, [End()]).start()
    told = perform(Memory(), inbox, "r $ repeat forward\n")
    assert any("halted or hung" in message["message"] for message in told if message["type"] == "error") is not reads
