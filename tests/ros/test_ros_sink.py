"""The ROS sink alone, in ROS's interpreter, and real subscribers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from tests.ros.conftest import LIMIT, Listen, Listener, Sink

TURTLE = {"turtle1": "/turtle1/cmd_vel"}


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
    assert sink("missing") == {"turtle1": f"nothing is listening on /turtle1/cmd_vel ({where})"}
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


@pytest.mark.parametrize(
    ("release", "given", "only", "reach"),
    [
        ("humble", "", "0", "this machine only"),  # sourcing Humble says 0
        ("humble", "SUBNET", "0", "the whole subnet"),
        ("humble", "SUBNET", "1", "this machine only"),
        ("jazzy", "SUBNET", "1", "this machine only"),
        ("jazzy", "SUBNET", "0", "the whole subnet"),
        ("kilted", "SUBNET", "1", "the whole subnet"),
    ],
)
def test_each_release_has_its_variable(
    start: Callable[..., Sink], release: str, given: str, only: str, reach: str
) -> None:
    sink = start(ROS_DISTRO=release, ROS_AUTOMATIC_DISCOVERY_RANGE=given, ROS_LOCALHOST_ONLY=only, ROS_DOMAIN_ID="101")
    assert sink.description == f"ROS 2, domain 101, {reach}"
