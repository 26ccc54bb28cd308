"""From a save in an editor to a real subscriber: the velocities and their order. Other tests check the times."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest

from tests.ros.conftest import Listener, Others
from tests.ros.dance import Server, moving, still

pytestmark = pytest.mark.slow("starts a server and its stages, and robots drive")

QUARTER = math.pi / 2


@pytest.fixture(scope="module")
def server(ros_env: Mapping[str, str]) -> Server:
    """A server with the simulator alongside."""
    return Server(ros_env, backend="auto")


@pytest.fixture(scope="module")
def everybody(others: Others, server: Server) -> Iterator[Listener]:
    """It stays while robots are stopped, because the server would otherwise keep telling them to stop."""
    listener = Listener(others, *(f"/{robot}/cmd_vel" for robot in ("turtle1", "ghost", "bert", "other")))
    yield listener
    server.client.__exit__(None, None, None)
    listener.close()


@pytest.fixture
def robots(everybody: Listener, server: Server) -> Iterator[Listener]:
    """The listener to all of them, which stand at the end."""
    everybody.hear_all()
    everybody.heard.clear()
    yield everybody
    server.client.request("workspace/executeCommand", {"command": "improv.hush"})


def topics(messages: list[dict[str, Any]]) -> set[str]:
    return {message["topic"] for message in messages if moving(message)}


def velocities(messages: list[dict[str, Any]]) -> list[dict[str, float]]:
    """Return each velocity once, without zeros: the first zeros may be pending from an earlier dance."""
    told = [{axis: message[axis] for axis in ("x", "y", "z", "yaw")} for message in messages if moving(message)]
    return [velocity for velocity, _ in groupby(told)]


def moves(robot: str) -> Callable[[Mapping[str, Any]], bool]:
    """Return a function that returns whether this robot moves, and not one from the previous test."""
    return lambda message: moving(message) and message["topic"] == f"/{robot}/cmd_vel"


def test_a_listener_hears_a_save_in_order_and_exactly_and_then_zeros(server: Server, robots: Listener) -> None:
    server.type("beat 120\nturtle1 $ forward [left right] strafeleft || rest rest up\n")
    server.client.save(server.uri)
    line = server.client.wait_for_line("▶")
    assert "▶ turtle1 3 beats, 1.5 s at beat 120, ROS 2, domain " in line
    assert line.endswith(", this machine only, with the simulator alongside")
    robots.wait(lambda message: message["y"] == 4)
    for _ in range(3):
        robots.wait(still)
    assert velocities(robots.heard) == [
        {"x": 4, "y": 0, "z": 0, "yaw": 0},
        {"x": 0, "y": 0, "z": 0, "yaw": pytest.approx(4 * QUARTER)},
        {"x": 0, "y": 0, "z": 0, "yaw": pytest.approx(-4 * QUARTER)},
        {"x": 0, "y": 4, "z": 4, "yaw": 0},
    ]


def test_a_dance_without_real_robots_plays_only_in_the_simulator(server: Server, robots: Listener) -> None:
    program = "x = repeat left\nturtle1 $ repeat forward\n"
    server.save(program)
    robots.wait(moves("turtle1"))
    server.client.request("workspace/executeCommand", {"command": "improv.play", "arguments": ["x"]})
    assert server.client.wait_for_line("▶ x: ").endswith("▶ x: ghost ∞, endless at beat 60, simulator")
    robots.wait(still)
    server.save(program)
    robots.wait(moves("turtle1"))
    assert topics(robots.heard) == {"/turtle1/cmd_vel"}


def test_a_robot_with_a_new_topic_is_stopped_on_the_old_one(server: Server, robots: Listener, tmp_path: Path) -> None:
    uri = (tmp_path / "dance.improv").as_uri()
    text = "bert $ repeat forward\n"
    server.client.open(uri, text)
    server.client.save(uri)
    robots.wait(moves("bert"))
    (tmp_path / "improv.toml").write_text('[robots.bert]\ntopic = "/other/cmd_vel"\n')
    server.client.save(uri)
    robots.wait(lambda message: still(message) and message["topic"] == "/bert/cmd_vel")
    robots.wait(moves("other"))
