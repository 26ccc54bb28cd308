"""From a save in an editor to a real subscriber: order, values, times, and that robots stop whatever happens."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from itertools import groupby, pairwise
from typing import Any

import pytest

from tests.ls.client import Client
from tests.processes import descendants, wait_until_gone
from tests.ros.conftest import Listener

URI = "file:///dance.improv"
OPTIONS = {"backend": "ros", "page": {"open": False}}
Listen = Callable[..., Listener]


def still(message: dict[str, Any]) -> bool:
    return not any(message[axis] for axis in ("x", "y", "z", "yaw"))


def moving(message: dict[str, Any]) -> bool:
    return not still(message)


def phases(messages: list[dict[str, Any]]) -> list[tuple[float, dict[str, float]]]:
    """Each velocity that was held, and for how long it was, until the next one came."""
    changes = []
    for velocity, group in groupby(messages, lambda message: {axis: message[axis] for axis in ("x", "y", "z", "yaw")}):
        changes.append((next(group)["at"], velocity))
    return [(after[0] - before[0], before[1]) for before, after in pairwise(changes)]


def test_save_is_heard_in_order_value_and_time(listen: Listen, ros_env: dict[str, str]) -> None:
    listener = listen("/turtle1/cmd_vel")
    with Client(OPTIONS, env=ros_env) as client:
        client.open(URI, "beat 120\nturtle1 $ forward [left right] strafeleft || rest rest up\n")
        client.save(URI)
        assert client.wait_for_line("▶").endswith(
            f"▶ turtle1 3 beats, 1.5 s at beat 120, ROS 2, domain {ros_env['ROS_DOMAIN_ID']}, this machine only"
        )
        listener.wait(moving)
        for _ in range(3):
            listener.wait(still)
    quarter = math.pi / 2
    heard = phases(listener.heard)
    assert [velocity for _, velocity in heard] == [
        {"x": 4, "y": 0, "z": 0, "yaw": 0},
        {"x": 0, "y": 0, "z": 0, "yaw": pytest.approx(4 * quarter)},
        {"x": 0, "y": 0, "z": 0, "yaw": pytest.approx(-4 * quarter)},
        {"x": 0, "y": 4, "z": 4, "yaw": 0},
    ]
    assert [held for held, _ in heard] == pytest.approx([0.5, 0.25, 0.25, 0.5], abs=0.02)
    assert all(still(message) for message in listener.heard[-3:])


def test_the_simulator_plays_beside_it_as_a_twin(listen: Listen, ros_env: dict[str, str]) -> None:
    listener = listen("/turtle1/cmd_vel")
    with Client({**OPTIONS, "backend": "auto"}, env=ros_env) as client:
        client.open(URI, "beat 120\nturtle1 $ forward\n")
        client.save(URI)
        assert client.wait_for_line("▶").endswith("this machine only, with the simulator alongside")
        listener.wait(moving)
        listener.wait(still)


def test_what_no_robot_plays_is_danced_in_the_simulator_alone(listen: Listen, ros_env: dict[str, str]) -> None:
    listener = listen("/turtle1/cmd_vel", "/ghost/cmd_vel")
    with Client({**OPTIONS, "backend": "both"}, env=ros_env) as client:
        client.open(URI, "x = repeat left\nturtle1 $ repeat forward\n")
        client.save(URI)
        listener.wait(moving)
        client.request("workspace/executeCommand", {"command": "improv.play", "arguments": ["x"]})
        assert client.wait_for_line("▶ x: ").endswith("▶ x: ghost ∞, endless at beat 60, simulator")
        listener.wait(still)
        client.save(URI)
        client.wait_for_line("▶ turtle1 ∞")
        listener.wait(moving)
    assert {message["topic"] for message in listener.heard} == {"/turtle1/cmd_vel"}


def test_a_wrong_save_lets_the_dance_go_on_and_hush_ends_it(listen: Listen, ros_env: dict[str, str]) -> None:
    listener = listen("/turtle1/cmd_vel")
    with Client(OPTIONS, env=ros_env) as client:
        client.open(URI, "turtle1 $ repeat forward\n")
        client.save(URI)
        listener.wait(moving)
        client.change(URI, 2, {"text": "turtle1 $ repeat (forward\n"})
        client.save(URI)
        client.wait_for_line("✗ line 1: close this bracket with `)`; the previous dance keeps playing")
        told = time.monotonic()
        assert listener.wait(lambda message: message["at"] > told)["x"] == 2
        assert not any(still(message) for message in listener.heard)
        client.request("workspace/executeCommand", {"command": "improv.hush"})
        listener.wait(still)


def test_listeners_of_stamped_twists_are_served(listen: Listen, ros_env: dict[str, str]) -> None:
    listener = listen("/turtle1/cmd_vel", "--stamped")
    with Client(OPTIONS, env=ros_env) as client:
        client.open(URI, "beat 120\nturtle1 $ forward\n")
        client.save(URI)
        assert listener.wait(moving)["x"] == 4
        listener.wait(still)


def test_a_robot_that_nobody_hears_is_named(listen: Listen, ros_env: dict[str, str]) -> None:
    listener = listen("/here/cmd_vel")
    with Client(OPTIONS, env=ros_env) as client:
        client.open(URI, "here $ repeat forward\ngone $ repeat left\n")
        client.save(URI)
        line = client.wait_for_line("nothing is listening on /gone/cmd_vel")
        assert line.endswith("this machine only)")
        listener.wait(moving)
        # The node and its publishers are kept: the next save need not wait for anything.
        client.change(URI, 2, {"text": "here $ repeat left\n"})
        client.save(URI)
        listener.wait(lambda message: message["yaw"] > 0)


def test_kill_of_the_server_stops_the_robots_and_leaves_nothing(listen: Listen, ros_env: dict[str, str]) -> None:
    listener = listen("/turtle1/cmd_vel")
    with Client({**OPTIONS, "backend": "both"}, env=ros_env) as client:
        client.open(URI, "turtle1 $ repeat (forward left)\n")
        client.save(URI)
        listener.wait(moving)
        ours = descendants(client.process.pid)
        assert len(ours) == 3, "two stages and a standby"
        killed = time.monotonic()
        client.process.kill()
        assert listener.wait(lambda message: message["at"] > killed and still(message))["at"] - killed < 0.5
        wait_until_gone(ours, 10)
