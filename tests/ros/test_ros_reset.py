"""A restart puts robots back by the services they offer, and waits for that only so long."""

from __future__ import annotations

from tests.ros.conftest import Listen, Sink

TOPICS = {"turtle1": "/turtle1/cmd_vel", "turtle2": "/turtle2/cmd_vel"}


def test_robots_are_stopped_reset_once_and_heard_again(sink: Sink, listen: Listen) -> None:
    turtles = listen(*TOPICS.values(), "--reset", "/reset")
    sink("prepare", TOPICS)
    sink("wait")
    sink("send", "turtle1", 1, 0, 0, 0)
    sink("prepare", TOPICS, reset="/reset")
    sink("wait")
    assert sink("warnings") == {}
    # The listeners are new ones, as after turtlesim's reset: the first command must not be lost.
    sink("send", "turtle1", 2, 0, 0, 0)
    turtles.wait(lambda message: message.get("x") == 2)
    stops = [("/turtle1/cmd_vel", 0.0), ("/turtle2/cmd_vel", 0.0)]
    assert told(turtles.heard[:1]) == [("/turtle1/cmd_vel", 1.0)]
    assert sorted(told(turtles.heard[1:3])) == stops
    assert told(turtles.heard[3:]) == [("/reset", None), ("/turtle1/cmd_vel", 2.0)]


def told(messages: list[dict[str, object]]) -> list[tuple[object, object]]:
    return [(message["topic"], message.get("x")) for message in messages]


def test_a_service_that_comes_with_its_robot_is_called_before_the_first_beat(sink: Sink, listen: Listen) -> None:
    sink("prepare", {"turtle1": "/turtle1/cmd_vel"}, reset="/reset")
    turtle = listen("/turtle1/cmd_vel", "--reset", "/reset")
    sink("wait")
    sink("send", "turtle1", 1, 0, 0, 0)
    turtle.wait(lambda message: message.get("x") == 1)
    assert "/reset" in [message["topic"] for message in turtle.heard]


def test_only_a_restart_resets(sink: Sink, listen: Listen) -> None:
    turtles = listen(*TOPICS.values(), "--reset", "/reset")
    sink("prepare", TOPICS)
    sink("wait")
    sink("prepare", TOPICS, False, reset="/reset")
    assert sink("resetting") is False
    sink("send", "turtle1", 1, 0, 0, 0)
    turtles.wait(lambda message: message.get("x") == 1)
    assert len(turtles.heard) == 1


def test_a_service_that_is_not_there_is_said_once(sink: Sink) -> None:
    sink("prepare", TOPICS, reset="/lab/reset")
    assert sink("wait_for_reset") < 5  # it waits half a second, and a busy machine longer
    line = "no node offers the service /lab/reset (std_srvs/srv/Empty), so these were not reset: turtle1, turtle2"
    assert sink("warnings") == {"turtle1": line}
    sink("prepare", TOPICS)
    assert sink("warnings") == {}


def test_a_service_that_does_not_answer_is_said(sink: Sink, listen: Listen) -> None:
    turtle = listen("/turtle1/cmd_vel", "--reset", "/reset", "--deaf")
    sink("prepare", {"turtle1": "/turtle1/cmd_vel"})
    sink("wait")
    sink("prepare", {"turtle1": "/turtle1/cmd_vel"}, reset="/reset")
    assert 0.4 < sink("wait_for_reset") < 1.1
    assert sink("warnings") == {"turtle1": "the service /reset has not answered, so these may not be reset: turtle1"}
    turtle.wait(lambda message: message["topic"] == "/reset")
