"""From a save in an editor to a real subscriber: the velocities and their order. Other tests check the times."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import groupby
from pathlib import Path
from typing import Any

import pytest

from tests.ros.conftest import Fields, Listen
from tests.ros.dance import Server, moving, still

pytestmark = pytest.mark.slow("starts a server and its stages, and robots drive")

QUARTER = math.pi / 2


def moves(robot: str) -> Callable[[Mapping[str, Any]], bool]:
    return lambda message: moving(message) and message["topic"] == f"/{robot}/cmd_vel"


def velocities(messages: list[Fields]) -> list[Fields]:
    """Return each velocity once, without zeros: the first ones only check that somebody hears."""
    told = [{axis: message[axis] for axis in ("x", "y", "z", "yaw")} for message in messages if moving(message)]
    return [velocity for velocity, _ in groupby(told)]


def test_robots_hear_each_save_in_order_and_exactly_and_then_zeros(
    listen: Listen, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    """A dance without real robots plays only in the simulator, and a robot is stopped on the topic that it leaves."""
    robots = listen(*(f"/{robot}/cmd_vel" for robot in ("turtle1", "ghost", "other")))
    with Server(ros_env, backend="auto", uri=(tmp_path / "dance.improv").as_uri()) as server:
        server.type("beat 120\nturtle1 $ forward [left right] strafeleft || rest rest up\n")
        server.client.save(server.uri)
        line = server.wait_for_line("▶")
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

        program = "x = repeat left\nturtle1 $ repeat forward\n"
        server.save(program)
        robots.wait(moves("turtle1"))
        server.client.request("workspace/executeCommand", {"command": "improv.only", "arguments": ["x"]})
        assert server.wait_for_line("▶ x: ").endswith("▶ x: ghost ∞, endless at beat 60, simulator")
        robots.wait(still)
        server.save(program)
        robots.wait(moves("turtle1"))
        assert not any(map(moves("ghost"), robots.heard))

        (tmp_path / "improv.toml").write_text('[robots.turtle1]\ntopic = "/other/cmd_vel"\n')
        server.client.save(server.uri)
        robots.wait(lambda message: still(message) and message["topic"] == "/turtle1/cmd_vel")
        robots.wait(moves("other"))
        server.client.request("workspace/executeCommand", {"command": "improv.stop"})
        robots.wait(still)
