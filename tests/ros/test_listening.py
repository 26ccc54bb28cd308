"""What people press while robots move: real publishers of an emergency stop and of a gamepad."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.ros.conftest import Listener, Script, Sense
from tests.ros.dance import (
    AFTER,
    AFTER_SPEED,
    BEFORE,
    BEFORE_SPEED,
    BY_STANDBY,
    SOON,
    Record,
    Server,
    at_speed,
    dances,
    stands,
    still,
)

PRESSER = Path(__file__).parent / "presser.py"
STOP = '[ros]\nstop = "/e_stop"\n'
DEADMAN = '[ros]\ndeadman = { topic = "/joy", button = 4 }\n'
REFUSED = "✗ the emergency stop on /e_stop is on: release it, then save again"
STOPPED = "the emergency stop on /e_stop is on, so all robots were stopped"


class Presser:
    """Somebody who publishes what is pressed."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.process = process

    def __call__(self, line: str) -> None:
        print(line, file=self.process.stdin, flush=True)


Press = Callable[..., Presser]


@pytest.fixture
def presser(script: Script) -> Press:
    return lambda *arguments: Presser(script(PRESSER, *arguments))


@pytest.fixture
def server(ros_env: dict[str, str], tmp_path: Path) -> Iterator[Callable[[str], Server]]:
    """Starts a server for a program beside an `improv.toml`."""
    started: list[Server] = []

    def start(toml: str) -> Server:
        (tmp_path / "improv.toml").write_text(toml)
        started.append(Server(ros_env, uri=(tmp_path / "dance.improv").as_uri()))
        return started[-1]

    yield start
    for each in started:
        each.__exit__(None)


def test_an_emergency_stop(
    presser: Press, server: Callable[[str], Server], turtle: Listener, record_property: Record
) -> None:
    """Of the kind that is hardest to hear: best effort. A latched one is below, and a reliable one is heard twice."""
    press = presser("--stop", "/e_stop", "--best-effort")
    conductor = server(STOP)
    dances(conductor, turtle)
    began = time.monotonic()
    press("stop true")
    stands(turtle, began, SOON, record_property)
    conductor.wait_for_line(STOPPED)
    conductor.type(AFTER)
    conductor.client.save(conductor.uri)
    conductor.wait_for_line(REFUSED)
    press("stop false")
    conductor.wait_for_line("the emergency stop on /e_stop is off: save to play again")
    assert all(still(message) for message in turtle.heard if message["at"] > began + SOON)
    conductor.save(AFTER)
    turtle.wait(at_speed(AFTER_SPEED))


def test_an_emergency_stop_that_is_on_before_the_first_save(
    presser: Press, server: Callable[[str], Server], turtle: Listener
) -> None:
    press = presser("--stop", "/e_stop", "--latched")
    press("stop true")
    began = time.monotonic()
    conductor = server(STOP)
    conductor.type(BEFORE)
    conductor.client.save(conductor.uri)
    conductor.wait_for_line(STOPPED)
    press("stop false")
    conductor.wait_for_line("the emergency stop on /e_stop is off: save to play again")
    conductor.save(AFTER)
    turtle.wait(at_speed(AFTER_SPEED))
    assert not any(at_speed(BEFORE_SPEED)(message) for message in turtle.heard if message["at"] > began)


def test_an_emergency_stop_that_nobody_publishes(server: Callable[[str], Server], turtle: Listener) -> None:
    conductor = server(STOP)
    conductor.save(BEFORE)
    conductor.wait_for_line("nobody publishes on /e_stop, so the emergency stop there stops nothing")
    turtle.wait(at_speed(BEFORE_SPEED))
    assert conductor.complaints() == []


def moves(turtle: Listener, since: float) -> None:
    turtle.wait(lambda message: message["at"] > since and at_speed(BEFORE_SPEED)(message))


def test_a_deadman_button(
    presser: Press, server: Callable[[str], Server], turtle: Listener, record_property: Record
) -> None:
    press = presser("--joy", "/joy")
    conductor = server(DEADMAN)
    began = time.monotonic()
    conductor.save(BEFORE)
    conductor.wait_for_line("paused: to let robots move, hold button 4 on /joy")
    for release in ("joy 0", "joy silent"):
        assert not any(message["x"] for message in turtle.heard if message["at"] > began)
        pressed = time.monotonic()
        press("joy 1")
        moves(turtle, pressed)  # on a busy machine it may also have moved before, after the button had seemed silent
        released = time.monotonic()
        press(release)
        began = stands(turtle, released, SOON, record_property)
        conductor.wait_for_line("paused: to let robots move, hold button 4 on /joy")
    press("joy 1")
    moves(turtle, began)
    another = presser("--joy", "/joy")
    another("joy 0")
    for _ in range(3):
        turtle.wait(still)
    assert all(map(still, turtle.heard[-3:])), "two gamepads pause robots, and don't start them in between"
    another("joy silent")
    moves(turtle, time.monotonic())


def test_a_stage_that_can_not_hear_a_button_any_more(
    presser: Press, sensor: Sense, server: Callable[[str], Server], turtle: Listener, record_property: Record
) -> None:
    press = presser("--joy", "/joy")
    conductor = server(f"{DEADMAN}use_sim_time = true\n")
    press("joy 1")
    conductor.save(BEFORE)
    moves(turtle, time.monotonic())
    clock = sensor("/clock", "rosgraph_msgs/Clock")
    began = time.monotonic()
    clock({"clock.sec": -1})
    conductor.wait_for_line("the stage failed: a message from ROS 2 can't be handled (Seconds value must not be ")
    stands(turtle, began, BY_STANDBY, record_property)
