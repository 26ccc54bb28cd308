"""The stage as a process: its messages, and its clean end in all cases."""

from __future__ import annotations

import json
import os
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import pytest

from improv_core import page
from improv_core.page.__main__ import SIGNALED
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.protocol.limits import LONGEST_LINE
from improv_core.score.score_json import to_json

LIMIT = 60
COMMAND = [sys.executable, str(Path(page.__file__).parent), "--simulate"]
DEEP = 100_000
SITE = Path(__file__).parents[1] / "ros" / "site"


def load(program: str) -> bytes:
    score = to_json(score_of(analyze(program)))
    message = {"type": "load", "generation": 1, "score": score, "when": "restart", "backend": "simulator"}
    return json.dumps(message).encode() + b"\n"


class Process:
    """The page with the simulator's stage, whose parent is the test."""

    def __init__(self, env: Mapping[str, str] = MappingProxyType({})) -> None:
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(COMMAND, stdin=pipe, stdout=pipe, stderr=pipe, env={**os.environ, **env})
        ready = self.wait("ready")
        assert ready["protocol"] == 3
        self.page: str = ready["page"]

    def write(self, line: bytes) -> None:
        assert self.process.stdin
        self.process.stdin.write(line)
        self.process.stdin.flush()

    def play(self, program: str) -> None:
        self.write(load(program))
        assert self.wait("transport")["state"] == "playing"

    def wait(self, kind: str) -> dict[str, Any]:
        """Return the next message of a type."""
        assert self.process.stdout
        for line in self.process.stdout:
            message: dict[str, Any] = json.loads(line)
            if message["type"] == kind:
                return message
        raise AssertionError(f"the stage ended before it said {kind}")

    def ends(self, code: int = 0, message: str | None = None) -> None:
        """Check that it reports that it stopped the robots, with this message, ends with this code, and prints
        nothing."""
        assert self.wait("transport")["state"] == "stopped"
        assert self.wait("stopped").get("message") == message
        assert self.process.stderr
        assert self.process.stderr.read() == b""
        assert self.process.wait(LIMIT) == code


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
    process.ends(1, SIGNALED)


def test_end_of_input_in_the_middle_of_a_line(process: Process) -> None:
    process.write(b'{"type": "load", "gener')
    assert process.process.stdin
    process.process.stdin.close()
    process.ends()


NOISE = """\
import os, threading
start = threading.Thread.start

def print_and_start(thread):
    os.write(1, b"no line end")
    print("a line", flush=True)
    start(thread)

threading.Thread.start = print_and_start
"""


def test_output_of_a_library_is_not_among_a_stages_messages() -> None:
    process = Process({"PYTHONPATH": str(SITE), "IMPROV_TEST_CODE": NOISE})
    assert process.process.stdin
    assert process.process.stderr
    process.play("r $ forward\n")
    process.process.stdin.close()
    assert process.wait("transport")["state"] == "stopped"
    process.wait("stopped")
    assert process.process.stderr.read().count(b"no line enda line\n") >= 2
    assert process.process.wait(LIMIT) == 0


HOSTILE = [
    b"[" * DEEP + b"]" * DEEP,
    b'{"type": "load", "score": ' + b'{"a":' * DEEP + b"1" + b"}" * DEEP + b"}",
    b'{"type": "seek", "beat": 1e999}',
    b'{"type": "seek", "beat": 1' + b"0" * 5000 + b"}",
    b'{"type": "stop"\xff}',
    b"\x00\x00\x00\x00",
    b'{"type": "' + b"x" * 100_000 + b'"}',
]


def test_a_stage_refuses_hostile_lines_and_still_obeys(process: Process) -> None:
    for number, line in enumerate(HOSTILE):
        process.write(line + b"\n")
        assert len(process.wait("error")["message"]) < 1_000
        process.write(b'{"type": "ping", "number": %d}\n' % number)  # only now: answers to pings overtake errors
        assert process.wait("pong")["number"] == number
    piece = b"x" * 1_000_000
    for _ in range(LONGEST_LINE // len(piece) + 36):
        process.write(piece)
    process.write(b"\n")
    assert process.wait("error")["message"] == "this program can't be played: it is longer than 64 MB"
    assert process.wait("transport")["state"] == "stopped"
    process.write(b'{"type": "ping", "number": 99}\n')
    assert process.wait("pong")["number"] == 99


def test_an_input_that_fails_ends_the_stage_which_stops_the_robots() -> None:
    listener = socket.create_server(("127.0.0.1", 0))
    ours = socket.create_connection(listener.getsockname())
    theirs, _ = listener.accept()
    process = subprocess.Popen(COMMAND, stdin=theirs.fileno(), stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    theirs.close()
    listener.close()
    assert process.stdout
    told = map(json.loads, process.stdout)
    ours.sendall(load("r $ repeat forward\n"))
    while next(told).get("state") != "playing":
        pass
    ours.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    ours.close()  # without a goodbye, so that reading fails
    *_, transport, stopped = told
    assert transport["state"] == "stopped"
    assert stopped["message"].startswith("the stage can't read its input: ")
    output, log = process.communicate(timeout=LIMIT)
    assert (output, log, process.returncode) == (b"", b"", 1)
