"""Faults while robots move: they stand, one line says so, and the next save plays.

The time depends on limits, which tests with a simulated clock check; `python -m tests.benchmarks faults` measures it.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from improv_core.safety.interlocks import OLDER
from tests.processes import players
from tests.ros.conftest import Listener, Others, a_domain, with_code, with_limits
from tests.ros.dance import (
    AFTER,
    AFTER_SPEED,
    BEFORE,
    BEFORE_SPEED,
    ENDED,
    Server,
    at_speed,
    dances,
    moving,
    still,
    survives,
)

pytestmark = pytest.mark.slow("processes are killed, and others take their places")

TOPICS = ("/turtle1/cmd_vel", "/turtle2/cmd_vel")
TWO = "turtle1 turtle2 $ repeat forward\n"

BROKEN = """\
import ctypes, pathlib
try:
    from rclpy.publisher import Publisher
except ImportError:  # in the server's Python
    pass
else:
    publish, folder = Publisher.publish, pathlib.Path({folder!r})

    def publish_or_fail(self, message):
        if (folder / "hang").exists():
            (folder / "hang").unlink()
            ctypes.PyDLL(None).sleep(600)
        if (folder / "broken").exists() and "turtle2" in self.topic_name:
            raise RuntimeError("failed to publish")
        publish(self, message)

    Publisher.publish = publish_or_fail
"""
"""Code with which a file `hang` keeps the next publisher in a C function that blocks all threads. While a file `broken`
exists, no message for turtle2 can be published."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("faults")


@pytest.fixture(scope="module")
def env(ros_env: Mapping[str, str], others: Others, folder: Path) -> Iterator[dict[str, str]]:
    """An environment with a domain in which processes may be killed, and short limits."""
    limits = with_limits(protocol__limits__HANG_LIMIT=3.0, protocol__limits__SILENCE_LIMIT=3.0)
    with a_domain() as domain:
        yield {**ros_env, **limits, **with_code(BROKEN.format(folder=str(folder))), "ROS_DOMAIN_ID": str(domain)}
        others.leave(domain)


@pytest.fixture(scope="module")
def turtles(others: Others, env: Mapping[str, str]) -> Iterator[list[Listener]]:
    """They stay until the server has ended, because it would otherwise keep telling them to stop."""
    turtles = [Listener(others, topic, domain=int(env["ROS_DOMAIN_ID"])) for topic in TOPICS]
    yield turtles
    for each in turtles:
        each.close()


@pytest.fixture(scope="module")
def server(env: Mapping[str, str], turtles: list[Listener]) -> Iterator[Server]:
    """One server for all faults: it survives them."""
    with Server(env) as server:
        yield server


def test_a_stage_that_hangs_in_a_c_call_is_replaced(server: Server, turtles: list[Listener], folder: Path) -> None:
    line = ": a new one is stopping the robots; play again"  # its standby may be first to kill it
    survives(server, turtles[0], lambda _: (folder / "hang").touch(), line)


def test_a_server_that_hangs_stops_the_robots_and_what_was_saved_meanwhile_moves_none(
    server: Server, turtles: list[Listener]
) -> None:
    turtle = turtles[0]
    dances(server, turtle)
    server.complaints()
    ours = players(server.pid)
    os.kill(server.pid, signal.SIGSTOP)
    try:
        turtle.wait(still)
        server.type(AFTER)
        server.client.save(server.uri)
    finally:
        os.kill(server.pid, signal.SIGCONT)
    server.wait_for_line("Improv was suspended or hung for 3.0 s, so all robots were stopped: play again")
    server.wait_for_line(OLDER)
    server.save_until_it_plays(BEFORE)
    assert at_speed(BEFORE_SPEED)(turtle.wait(moving)), "the save from before the stop moves nothing"
    said = [str(each.message) for each in server.client.log if "showMessage" in str(each.message.get("method"))]
    refused = next(place for place, line in enumerate(said) if OLDER in line)
    assert not any("beat 90" in line for line in said[refused:]), "a refused program counts as started"
    assert players(server.pid).keys() == ours.keys()


def test_an_unreachable_robot_stops_the_others(server: Server, turtles: list[Listener], folder: Path) -> None:
    """The stages stop the others, a new stage doesn't retry forever, and each of the two reports the error once."""
    server.save(TWO)
    for turtle in turtles:
        turtle.wait(at_speed(BEFORE_SPEED))
    server.complaints()
    (folder / "broken").touch()
    turtles[0].wait(still)
    server.wait_for_line("the stage failed: failed to publish: a new one is stopping the robots; play again")
    server.wait_for_line("the stage failed: failed to publish: robots may still be moving; play again")
    assert players(server.pid) == {}
    (folder / "broken").unlink()
    server.save("beat 90\n" + TWO)
    for turtle in turtles:
        turtle.wait(at_speed(AFTER_SPEED))
    assert server.complaints() == []


def test_without_a_standby_a_new_stage_stops_the_robots_and_a_command_has_them_resume(
    env: Mapping[str, str], turtles: list[Listener]
) -> None:
    turtle = turtles[0]
    with Server(env, standby=False) as server:
        dances(server, turtle)
        (stage,) = players(server.pid)
        os.kill(stage, signal.SIGKILL)
        server.wait_for_line(ENDED)
        turtle.wait(still)
        server.wait_for_line("Robots were stopped: resume by the code actions")
        turtle.hear_all()
        server.client.request("workspace/executeCommand", {"command": "improv.resume", "arguments": [0.0]})
        turtle.wait(at_speed(BEFORE_SPEED))
