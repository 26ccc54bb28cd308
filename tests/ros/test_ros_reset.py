"""A restart calls the services that reset robots, and waits for them only so long."""

from __future__ import annotations

import pytest

from tests.ros.conftest import Listen, Sink, Start, with_limits

pytestmark = pytest.mark.slow("processes of ROS find each other")

TOPICS = {"turtle1": "/turtle1/cmd_vel", "turtle2": "/turtle2/cmd_vel"}


def test_robots_are_stopped_reset_once_and_heard_again(sink: Sink, listen: Listen) -> None:
    turtles, witness = listen(*TOPICS.values(), reset="/reset"), listen(*TOPICS.values(), name="witness")
    sink("prepare", TOPICS)
    sink("wait", listeners=2)
    sink("send", "turtle1", 1, 0, 0, 0)
    sink("prepare", TOPICS, reset="/reset")
    sink("wait", listeners=2)
    assert sink("warnings") == {}
    # The listeners are new ones, as after turtlesim's reset: the first command must not be lost.
    sink("send", "turtle1", 2, 0, 0, 0)
    turtles.wait(lambda message: message.get("x") == 2)
    assert [message["topic"] for message in turtles.heard].count("/reset") == 1
    witness.wait(lambda message: message["x"] == 2)
    told = {(message["topic"], message["x"]) for message in witness.heard}
    assert {("/turtle1/cmd_vel", 0), ("/turtle2/cmd_vel", 0)} <= told
    sink("prepare", TOPICS, False, reset="/reset")
    assert sink("resetting") is False, "only a restart resets"


def test_a_service_that_starts_with_its_robot_is_called_before_the_first_beat(sink: Sink, listen: Listen) -> None:
    sink("prepare", {"turtle1": "/turtle1/cmd_vel"}, reset="/reset")
    turtle = listen("/turtle1/cmd_vel", reset="/reset")
    sink("wait")
    turtle.wait(lambda message: message["topic"] == "/reset")
    sink("send", "turtle1", 1, 0, 0, 0)
    turtle.wait(lambda message: message.get("x") == 1)


def test_a_missing_service_is_reported_once(start: Start) -> None:
    sink = start(**with_limits(outputs__ros__reset__LIMIT=0.5))
    topics = {robot: f"/lab{topic}" for robot, topic in TOPICS.items()}  # earlier sinks may still be known on theirs
    sink("prepare", topics, reset="/lab/reset")
    sink("wait_for_reset")
    line = "no node offers the service /lab/reset (std_srvs/srv/Empty), so these were not reset: turtle1, turtle2"
    assert sink("warnings") == {"turtle1": line}
    sink("prepare", topics)
    assert sink("warnings") == {}


def test_a_service_that_does_not_answer_is_reported(start: Start, listen: Listen) -> None:
    sink = start(**with_limits(outputs__ros__reset__LIMIT=3.0))  # it is found by then
    turtle = listen("/deaf/cmd_vel", reset="/reset", deaf=True, name="deaf")
    sink("prepare", {"turtle1": "/deaf/cmd_vel"})
    sink("wait")
    sink("prepare", {"turtle1": "/deaf/cmd_vel"}, reset="/reset")
    sink("wait_for_reset")
    assert sink("warnings") == {"turtle1": "the service /reset has not answered, so these may not be reset: turtle1"}
    turtle.wait(lambda message: message["topic"] == "/reset")
