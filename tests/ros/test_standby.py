"""A stage that can't stop its robots any more: its standby does."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable

import pytest

from tests.processes import descendants, wait_until_gone
from tests.ros.conftest import LIMIT, Listen, Listener, Sink
from tests.ros.dance import BY_STANDBY, Record, stands, still

TOPICS = ("/turtle1/cmd_vel", "/turtle2/cmd_vel")


@pytest.fixture
def sink(start: Callable[..., Sink]) -> Sink:
    return start("standby")


def moving(listen: Listen, sink: Sink) -> Listener:
    """One robot moves and another stands; a subscriber hears both."""
    turtles = listen(*TOPICS)
    sink("prepare", {"turtle1": TOPICS[0], "turtle2": TOPICS[1]})
    sink("wait")
    sink("send", "turtle1", 1.0, 0.0, 0.0, 0.0)
    turtles.wait(lambda message: message["x"] == 1.0)
    return turtles


FAULTS: dict[str, Callable[[int], None]] = {
    "killed": lambda pid: os.kill(pid, signal.SIGKILL),
    "halted": lambda pid: os.kill(pid, signal.SIGSTOP),
    "hung": lambda pid: None,  # between two calls the driver does nothing: nobody hears that it lives
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_stage_that_fails(fault: str, listen: Listen, sink: Sink, record_property: Record) -> None:
    turtles = moving(listen, sink)
    standby = descendants(sink.process.pid)
    began = time.monotonic()
    FAULTS[fault](sink.process.pid)
    stands(turtles, began, BY_STANDBY, record_property)
    wait_until_gone(standby, LIMIT)
    assert sink.process.wait(LIMIT) == -signal.SIGKILL
    turtles.close()
    assert {message["topic"] for message in turtles.heard if still(message)} == {TOPICS[0]}, (
        "turtle2 is not ours to move"
    )


def test_a_stage_that_has_stopped_its_robots(listen: Listen, sink: Sink) -> None:
    turtles = moving(listen, sink)
    sink("send", "turtle1", 0.0, 0.0, 0.0, 0.0)
    turtles.wait(still)
    heard = len(turtles.heard)
    ours = descendants(sink.process.pid)
    sink.process.kill()
    wait_until_gone(ours, LIMIT)
    turtles.close()
    assert len(turtles.heard) == heard


def test_a_stage_that_ends_while_a_robot_moves(listen: Listen, sink: Sink) -> None:
    """The standby stops the robot and lets the stage end by itself, so its last message is not lost."""
    turtles = moving(listen, sink)
    sink.close()
    turtles.wait(still)
    assert sink.process.returncode == 0
