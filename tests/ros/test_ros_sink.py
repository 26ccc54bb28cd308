"""The ROS sink alone, in ROS's interpreter, and real subscribers."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from tests.ros.conftest import LIMIT, Listener

DRIVER = Path(__file__).parent / "driver.py"
TURTLE = {"turtle1": "/turtle1/cmd_vel"}
Listen = Callable[..., Listener]


class Sink:
    """The sink in a process of its own: `sink("missing")` calls the method and returns its answer."""

    def __init__(self, python: str, env: Mapping[str, str]) -> None:
        self.process = subprocess.Popen(
            [python, DRIVER], env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.description = self._answer()

    def __call__(self, method: str, *arguments: Any) -> Any:
        assert self.process.stdin
        self.process.stdin.write(json.dumps([method, *arguments]) + "\n")
        self.process.stdin.flush()
        return self._answer()

    def close(self) -> None:
        self.process.communicate(timeout=LIMIT)

    def _answer(self) -> Any:
        assert self.process.stdout
        return json.loads(self.process.stdout.readline())


@pytest.fixture
def start(ros_python: str, ros_env: dict[str, str]) -> Iterator[Callable[..., Sink]]:
    """Starts sinks, with variables that differ from the environment of all tests."""
    sinks: list[Sink] = []

    def begin(**variables: str) -> Sink:
        sinks.append(Sink(ros_python, {**ros_env, **variables}))
        return sinks[-1]

    yield begin
    for sink in sinks:
        sink.close()


@pytest.fixture
def sink(start: Callable[..., Sink]) -> Sink:
    return start()


def heard(listener: Listener, topic: str = "/turtle1/cmd_vel") -> list[tuple[float, ...]]:
    messages = [message for message in listener.heard if message["topic"] == topic]
    return [(message["x"], message["y"], message["z"], message["yaw"]) for message in messages]


def last(message: dict[str, Any]) -> bool:
    return bool(message["yaw"] == 9)


@pytest.mark.parametrize("kind", [(), ("--stamped",)], ids=["Twist", "TwistStamped"])
def test_every_twist_arrives_as_it_is_in_order(sink: Sink, listen: Listen, kind: tuple[str, ...]) -> None:
    listener = listen("/turtle1/cmd_vel", *kind)
    sink("prepare", TURTLE)
    sink("wait")
    # A whole number comes from JSON as an int, which rclpy would take for another number without a word.
    twists = [(0.5, -0.25, 0.125, -1.5), (2, 0, 0, 0), (0.0, 0.0, 0.0, 0.0), (1e-9, 0.0, 0.0, 0.0), (0, 0, 0, 9)]
    for twist in twists:
        sink("send", "turtle1", *twist)
    listener.wait(last)
    assert heard(listener) == twists


def test_who_is_not_heard_is_named_until_a_listener_comes(sink: Sink, listen: Listen, ros_env: dict[str, str]) -> None:
    sink("prepare", TURTLE)
    where = f"ROS 2, domain {ros_env['ROS_DOMAIN_ID']}, this machine only"
    assert sink("missing") == {"turtle1": f"nobody listens on /turtle1/cmd_vel ({where})"}
    listen("/turtle1/cmd_vel")
    sink("wait")
    assert sink("missing") == {}


def test_publishers_are_kept_over_later_scores(sink: Sink, listen: Listen) -> None:
    listener = listen("/turtle1/cmd_vel", "/new/cmd_vel")
    sink("prepare", TURTLE)
    sink("wait")
    sink("prepare", {**TURTLE, "new": "/new/cmd_vel"})
    assert list(sink("missing")) == ["new"]
    sink("send", "turtle1", 1, 0, 0, 0)  # heard without waiting again
    sink("prepare", {"new": "/new/cmd_vel"})
    sink("wait")
    sink("send", "turtle1", 2, 0, 0, 0)  # a robot that no longer plays can still be stopped
    sink("send", "new", 0, 0, 0, 9)
    listener.wait(last)
    assert heard(listener) == [(1, 0, 0, 0), (2, 0, 0, 0)]
    assert heard(listener, "/new/cmd_vel") == [(0, 0, 0, 9)]


def test_a_score_that_takes_over_misses_nobody_who_is_there(sink: Sink, listen: Listen) -> None:
    listener = listen("/turtle1/cmd_vel", "/new/cmd_vel")
    sink("prepare", TURTLE)
    sink("wait")
    sink("prepare", {**TURTLE, "new": "/new/cmd_vel"}, False)
    assert sink("missing") == {}
    sink("send", "new", 0, 0, 0, 9)
    listener.wait(last)


def test_signals_are_ours_and_the_last_zero_still_goes_out(sink: Sink, listen: Listen) -> None:
    listener = listen("/turtle1/cmd_vel")
    sink("prepare", TURTLE)
    sink("wait")
    sink("send", "turtle1", 1, 0, 0, 0)
    sink.process.terminate()
    listener.wait(lambda message: message["x"] == 0)
    assert sink.process.wait(LIMIT) == 0


@pytest.mark.parametrize(
    ("given", "reach"),
    [("", "this machine only"), ("OFF", "no discovery"), ("localhost", "this machine only")],
)
def test_the_environment_says_how_far_it_reaches(start: Callable[..., Sink], given: str, reach: str) -> None:
    sink = start(ROS_AUTOMATIC_DISCOVERY_RANGE=given, ROS_DOMAIN_ID="101")
    assert sink.description == f"ROS 2, domain 101, {reach}"
