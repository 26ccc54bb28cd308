"""Whoever ends that has to do with what plays, and however: robots stand, and nothing is left running."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from improv_core import stage as stage_package
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.score_json import to_json
from tests.processes import descendants, in_session, wait_until_full, wait_until_gone
from tests.ros.conftest import LIMIT, Listener
from tests.ros.dance import (
    AFTER,
    AFTER_SPEED,
    BEFORE,
    BEFORE_SPEED,
    BY_STANDBY,
    ENDED,
    SIGNALS,
    SOON,
    Record,
    Server,
    Terminal,
    at_speed,
    dances,
    plays_the_next_save,
    stands,
    still,
    survives,
)

PULSE = 3.0
"""Seconds after which a server that can't say anything counts as hung: PULSE_LIMIT in stage/process.py."""


def test_the_end_of_the_server(turtle: Listener, ros_env: dict[str, str], record_property: Record) -> None:
    for number in SIGNALS:
        with Server(ros_env) as server:
            dances(server, turtle)
            ours = descendants(server.pid)
            began = time.monotonic()
            os.kill(server.pid, number)
            zero = stands(turtle, began, SOON, record_property)
            wait_until_gone(ours, LIMIT)
    with Server(ros_env) as server:
        plays_the_next_save(server, turtle, zero)
        assert server.complaints() == []


@contextmanager
def an_editor(env: dict[str, str], turtle: Listener) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """One in a process of its own, the process id of its server, and a dance; nothing of it is left."""
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.ros.editor", BEFORE],
        env=env,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=Path(__file__).parents[2],
    )
    with process:
        assert process.stdout
        server = int(process.stdout.readline())
        ours = descendants(process.pid)
        assert len(ours) == 3, "the server, its stage and the standby"
        turtle.wait(at_speed(BEFORE_SPEED))
        yield process, server
        process.kill()
        wait_until_gone(ours, LIMIT)


def deafen(process: subprocess.Popen[str], server: int) -> None:
    """Have an editor read no more, and its server say more than the pipe between them holds."""
    assert process.stdin
    print(json.dumps(AFTER), file=process.stdin, flush=True)
    wait_until_full(server, LIMIT)


def test_the_end_of_the_editor(turtle: Listener, ros_env: dict[str, str], record_property: Record) -> None:
    with an_editor(ros_env, turtle) as (process, _):
        began = time.monotonic()
        process.kill()
        stands(turtle, began, SOON, record_property)


def test_the_end_of_an_editor_that_reads_no_more(
    turtle: Listener, ros_env: dict[str, str], record_property: Record
) -> None:
    with an_editor(ros_env, turtle) as (process, server):
        deafen(process, server)
        began = time.monotonic()
        process.kill()
        stands(turtle, began, SOON, record_property)


def test_an_editor_that_reads_no_more(turtle: Listener, ros_env: dict[str, str], record_property: Record) -> None:
    with an_editor(ros_env, turtle) as (process, server):
        began = time.monotonic()
        deafen(process, server)
        zero = stands(turtle, began, PULSE + SOON, record_property)
        process.send_signal(signal.SIGCONT)
        turtle.wait(at_speed(AFTER_SPEED))
        assert all(still(message) for message in turtle.heard[:-1] if message["at"] >= zero)
        assert process.stdout
        assert json.loads(process.stdout.readline()) == [], "one line is all that is said"


def test_input_of_the_stage_that_ends_in_the_middle_of_a_line(
    turtle: Listener, ros_python: str, ros_env: dict[str, str], record_property: Record
) -> None:
    folder = Path(stage_package.__file__).parent
    pipe = subprocess.PIPE
    process = subprocess.Popen([ros_python, folder, "--sink", "ros"], stdin=pipe, stdout=pipe, env=ros_env)
    assert process.stdin
    assert process.stdout
    score = to_json(score_of(analyze(BEFORE)))
    load = {"type": "load", "generation": 1, "score": score, "when": "restart", "backend": "ROS 2"}
    process.stdin.write(json.dumps(load).encode() + b"\n")
    process.stdin.flush()
    turtle.wait(at_speed(BEFORE_SPEED))
    began = time.monotonic()
    process.stdin.write(b'{"type": "load", "gener')
    process.stdin.close()
    stands(turtle, began, SOON, record_property)
    assert json.loads(process.stdout.readlines()[-1]) == {"type": "stopped"}
    assert process.wait(LIMIT) == 0


@pytest.fixture
def program(tmp_path: Path) -> Path:
    return tmp_path / "dance.improv"


def test_the_end_of_the_stage_of_a_watched_file(
    program: Path, turtle: Listener, ros_env: dict[str, str], record_property: Record
) -> None:
    with Terminal("watch", program, ros_env) as terminal:
        survives(terminal, turtle, lambda stage: os.kill(stage, signal.SIGKILL), ENDED, BY_STANDBY, record_property)
        terminal.process.terminate()
        assert terminal.end() == (130, "")
        assert in_session(terminal.pid) == []


def test_the_end_of_the_stage_of_a_played_file(
    program: Path, turtle: Listener, ros_env: dict[str, str], record_property: Record
) -> None:
    with Terminal("play", program, ros_env) as terminal:
        dances(terminal, turtle)
        ours = descendants(terminal.pid)
        stage, _ = ours
        began = time.monotonic()
        os.kill(stage, signal.SIGKILL)
        wait_until_gone(ours, LIMIT)
        assert terminal.end() == (2, f"improv: {ENDED}\n")
        assert in_session(terminal.pid) == []
        stands(turtle, began, BY_STANDBY, record_property)


def test_ctrl_z_stops_the_robots(
    program: Path, turtle: Listener, ros_env: dict[str, str], record_property: Record
) -> None:
    with Terminal("watch", program, ros_env) as terminal:
        dances(terminal, turtle)
        began = time.monotonic()
        os.killpg(terminal.pid, signal.SIGSTOP)  # SIGTSTP halts nothing in a session that has no terminal
        stands(turtle, began, SOON, record_property)
        os.killpg(terminal.pid, signal.SIGCONT)


ENDS_OF_PLAY: dict[str, tuple[Callable[[int], None], int]] = {
    "Ctrl-C": (lambda pid: os.killpg(pid, signal.SIGINT), 130),
    "SIGTERM": (lambda pid: os.kill(pid, signal.SIGTERM), 130),
    "SIGKILL": (lambda pid: os.kill(pid, signal.SIGKILL), -signal.SIGKILL),
}


@pytest.mark.parametrize("how", ENDS_OF_PLAY)
def test_the_end_of_what_plays_a_file(
    how: str, program: Path, turtle: Listener, ros_env: dict[str, str], record_property: Record
) -> None:
    end, code = ENDS_OF_PLAY[how]
    with Terminal("play", program, ros_env) as terminal:
        dances(terminal, turtle)
        ours = descendants(terminal.pid)
        assert len(ours) == 2
        began = time.monotonic()
        end(terminal.pid)
        stands(turtle, began, SOON, record_property)
        assert terminal.end() == (code, "")
        wait_until_gone(ours, LIMIT)
