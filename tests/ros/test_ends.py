"""Each end of a process that takes part in a dance: robots stand, and no process is left running."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.processes import descendants, in_session, wait_until_full, wait_until_gone
from tests.ros.conftest import LIMIT, Listen, Listener, with_limits
from tests.ros.dance import (
    AFTER,
    AFTER_SPEED,
    BEFORE,
    BEFORE_SPEED,
    ENDED,
    Server,
    Terminal,
    at_speed,
    dances,
    moving,
    still,
    survives,
)

pytestmark = pytest.mark.slow("starts what plays, to end it")


@pytest.fixture
def turtle(listen: Listen) -> Listener:
    return listen("/turtle1/cmd_vel")


def test_robots_stand_if_the_server_is_killed(turtle: Listener, alone: Mapping[str, str]) -> None:
    """A server with two stages, since it also simulates the robots."""
    with Server(alone, backend="auto") as server:
        dances(server, turtle)
        ours = descendants(server.pid)
        assert len(ours) == 3, "two stages and a standby"
        os.kill(server.pid, signal.SIGKILL)
        server.client.code = -signal.SIGKILL
        turtle.wait(still)
        wait_until_gone(ours, LIMIT)


@contextmanager
def an_editor(env: Mapping[str, str], turtle: Listener) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """Run a dance in an editor's own process. Yield the process and its server's process id. On exit, kill it: its
    robots stand, and no process of it is left."""
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.ros.editor", BEFORE],
        env={**env, **with_limits(protocol__limits__SILENCE_LIMIT=3.0)},
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
        turtle.wait(still)
        wait_until_gone(ours, LIMIT)


def deafen(process: subprocess.Popen[str], server: int) -> None:
    """Stop an editor from reading, and make its server write more than the pipe between them holds."""
    assert process.stdin
    print(json.dumps(AFTER), file=process.stdin, flush=True)
    wait_until_full(server, LIMIT)


def test_an_editor_that_stops_reading_for_a_while_and_ends_when_it_does_so_again(
    turtle: Listener, alone: Mapping[str, str]
) -> None:
    with an_editor(alone, turtle) as (process, server):
        deafen(process, server)
        turtle.wait(still)
        turtle.hear_all()
        process.send_signal(signal.SIGCONT)
        moves = turtle.wait(moving)
        assert at_speed(AFTER_SPEED)(moves), "nothing has moved before"
        assert process.stdout
        said = json.loads(process.stdout.readline())
        others = [line for line in said if " ms late: " not in line and "resume by the code actions" not in line]
        assert others == [], "one line, besides the offer to resume and how busy the machine is"
        deafen(process, server)


def test_a_watched_file_plays_on_after_its_stage_has_ended_and_robots_stand_while_it_is_halted(
    turtle: Listener, alone: Mapping[str, str], tmp_path: Path
) -> None:
    env = {**alone, **with_limits(protocol__limits__SILENCE_LIMIT=3.0)}
    with Terminal("watch", tmp_path / "dance.improv", env) as terminal:
        survives(terminal, turtle, lambda stage: os.kill(stage, signal.SIGKILL), ENDED)
        os.killpg(terminal.pid, signal.SIGSTOP)  # SIGTSTP halts nothing in a session that has no terminal
        turtle.wait(still)
        os.killpg(terminal.pid, signal.SIGCONT)
        terminal.process.terminate()
        code, _ = terminal.end()
        assert code == 130
        assert in_session(terminal.pid) == []


def test_ctrl_c_ends_what_plays_a_file(turtle: Listener, alone: Mapping[str, str], tmp_path: Path) -> None:
    env = {**alone, **with_limits(player__subscribers__PATIENCE=LIMIT)}
    with Terminal("play", tmp_path / "dance.improv", env) as terminal:
        dances(terminal, turtle)
        ours = descendants(terminal.pid)
        assert len(ours) == 2
        os.killpg(terminal.pid, signal.SIGINT)
        turtle.wait(still)
        assert terminal.end() == (130, "")
        wait_until_gone(ours, LIMIT)
        assert in_session(terminal.pid) == []
