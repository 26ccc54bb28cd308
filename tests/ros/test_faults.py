"""Whatever fails while robots move: they stand within half a second, one line says so, and the next save plays."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import suppress

import pytest

from tests.ros.conftest import Listener
from tests.ros.dance import (
    BEFORE_SPEED,
    BY_STANDBY,
    DEADLY,
    ENDED,
    SOON,
    URI,
    Record,
    Server,
    at_speed,
    dances,
    plays_the_next_save,
    still,
    survives,
)

STOPPED = 2.0
"""Seconds for which a process is stopped."""


@pytest.fixture(scope="module")
def server(turtle: Listener, ros_env: dict[str, str]) -> Iterator[Server]:
    """One for all faults that it survives."""
    with Server(ros_env) as server:
        yield server


def stop_for_a_while(pid: int) -> None:
    """Stop a process, and continue it whether or not another has taken its place."""

    def go_on() -> None:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGCONT)

    os.kill(pid, signal.SIGSTOP)
    threading.Timer(STOPPED, go_on).start()


@DEADLY
def test_the_end_of_the_stage(
    number: signal.Signals, server: Server, turtle: Listener, record_property: Record
) -> None:
    survives(server, turtle, lambda stage: os.kill(stage, number), ENDED, BY_STANDBY, record_property)


def test_a_stage_that_is_halted(server: Server, turtle: Listener, record_property: Record) -> None:
    survives(server, turtle, stop_for_a_while, ENDED, BY_STANDBY, record_property)


def test_a_server_that_hangs(server: Server, turtle: Listener, record_property: Record) -> None:
    line = "Improv was suspended or hung for 0.5 s, so all robots were stopped: save to play again"
    survives(server, turtle, lambda _: stop_for_a_while(server.pid), line, SOON, record_property)


def test_ten_saves_at_once_end_in_the_last(server: Server, turtle: Listener) -> None:
    dances(server, turtle)
    for tempo in range(100, 110):
        server.type(f"beat {tempo}\nturtle1 $ forward\n")
        server.client.save(URI)
    first = turtle.wait(at_speed(109 * BEFORE_SPEED / 60))["at"]
    last = turtle.wait(still)["at"]
    for _ in range(10):
        server.wait_for_line("▶")
    assert last - first == pytest.approx(60 / 109, abs=0.25)
    plays_the_next_save(server, turtle, last)
