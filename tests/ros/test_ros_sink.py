"""The ROS sink alone, in ROS's interpreter, and real subscribers."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator, Mapping
from itertools import dropwhile
from pathlib import Path
from typing import Any

import pytest

from improv_core.outputs.ros.nodes import PROFILES
from tests.ros.conftest import LIMIT, STAMPED, Listen, Listener, Others, Sink, Start, with_limits
from tests.ros.dance import at_speed, still

pytestmark = pytest.mark.slow("processes of ROS find each other")

TURTLE = {"turtle1": "/turtle1/cmd_vel"}


def heard(listener: Listener, topic: str = "/turtle1/cmd_vel") -> list[tuple[float, ...]]:
    """Return its messages without the first zeros, which only check that it hears."""
    messages = [message for message in listener.heard if message["topic"] == topic]
    return list(dropwhile(lambda twist: not any(twist), map(twist, messages)))


def twist(message: dict[str, Any]) -> tuple[float, ...]:
    return message["x"], message["y"], message["z"], message["yaw"]


def last(message: dict[str, Any]) -> bool:
    return bool(message["yaw"] == 9)


@pytest.mark.parametrize("kind", ["geometry_msgs/Twist", STAMPED])
def test_every_twist_arrives_as_it_is_in_order(sink: Sink, listen: Listen, kind: str) -> None:
    listener = listen("/turtle1/cmd_vel", type=kind)
    sink("prepare", TURTLE)
    sink("wait")
    # A whole number comes from JSON as an int, which rclpy would silently take for another number.
    twists = [(0.5, -0.25, 0.125, -1.5), (2, 0, 0, 0), (0.0, 0.0, 0.0, 0.0), (1e-9, 0.0, 0.0, 0.0), (0, 0, 0, 9)]
    for twist in twists:
        sink("send", "turtle1", *twist)
    listener.wait(last)
    assert heard(listener) == twists


def test_nodes_announce_themselves_from_a_thread_of_their_own(start: Start) -> None:
    """Most robots' answers then reach them: fast_dds.xml says why."""
    plain = start(**{PROFILES: ""})
    assert senders(start()) == senders(plain) + 1


def senders(sink: Sink) -> int:
    """Return the number of threads from which Fast DDS sends."""
    threads = Path(f"/proc/{sink.process.pid}/task").iterdir()
    return sum((each / "comm").read_text().startswith("dds.asyn") for each in threads)


def test_a_zero_that_cannot_be_published_keeps_no_other_one_back(sink: Sink, listen: Listen) -> None:
    robots = {"a": "/a/cmd_vel", "b": "/b/cmd_vel", "c": "/c/cmd_vel"}
    listener = listen(*robots.values())
    sink("prepare", robots)
    sink("wait", 1)
    for robot in robots:
        sink("send", robot, 1, 0, 0, 0)
    assert sink("stop_without", "b") == ["/b/cmd_vel"]
    for robot in ("a", "c"):
        sink("send", robot, 0, 0, 0, 9)
        listener.wait(last)
        assert heard(listener, robots[robot]) == [(1, 0, 0, 0), (0, 0, 0, 0), (0, 0, 0, 9)]


def test_puppets_are_told_nothing_and_waited_for_by_nobody(sink: Sink, listen: Listen) -> None:
    listener = listen("/turtle1/cmd_vel", "/ada/cmd_vel")
    sink("prepare", {**TURTLE, "ada": "/ada/cmd_vel", "bo": "/bo/cmd_vel"}, puppets=["ada", "bo"])
    sink("wait")
    line = (
        "bo is a puppet, which only the simulator has: to move a real robot, give it the profile of one in improv.toml"
    )
    assert sink("find", "warnings", "bo", "puppet") == line
    sink("send", "ada", 1, 0, 0, 0)
    sink("send", "turtle1", 0, 0, 0, 9)
    listener.wait(last)
    assert not any(any(twist(message)) for message in listener.heard if message["topic"] == "/ada/cmd_vel")


NEVER_STOPS = {"stops_after": 0.0}


def test_a_base_that_never_stops_by_itself_stands_without_a_standby_unless_that_is_accepted(
    sink: Sink, listen: Listen
) -> None:
    listener = listen("/turtle1/cmd_vel")
    sink("prepare", TURTLE, profile=NEVER_STOPS)
    line = (
        "turtle1 never stops by itself, and no standby could stop it: "
        "turn on `ros.standby`, or set `accept_no_stop = true` in its profile"
    )
    assert sink("missing") == {"turtle1": line}
    sink("send", "turtle1", 1, 0, 0, 0)
    sink("prepare", TURTLE, profile={**NEVER_STOPS, "accept_no_stop": True})
    sink("wait")
    sink("send", "turtle1", 0, 0, 0, 9)
    listener.wait(last)
    assert heard(listener) == [(0, 0, 0, 9)]


def test_a_base_that_never_stops_by_itself_moves_beside_a_standby(start: Start, listen: Listen) -> None:
    listener, sink = listen("/turtle1/cmd_vel"), start("standby")
    sink("prepare", TURTLE, profile=NEVER_STOPS)
    sink("wait")
    sink("send", "turtle1", 0, 0, 0, 9)
    listener.wait(last)


def test_topics_without_listeners_are_named_until_one_comes(
    sink: Sink, listen: Listen, ros_env: dict[str, str]
) -> None:
    sink("prepare", TURTLE)
    where = f"ROS 2, domain {ros_env['ROS_DOMAIN_ID']}, this machine only"
    assert sink("missing") == {"turtle1": f"nothing is listening on /turtle1/cmd_vel ({where})"}
    for _ in range(2):
        listener = listen("/turtle1/cmd_vel")
        sink("wait")
        assert sink("missing") == {}
        listener.close()
        assert sink("find", "missing", "turtle1", where) == f"nothing is listening on /turtle1/cmd_vel ({where})"


def test_a_killed_listener_affects_no_other_and_is_served_when_it_returns(
    start: Start, listen: Listen, fragile: Others
) -> None:
    here, gone = listen("/turtle1/cmd_vel"), Listener(fragile, "/turtle2/cmd_vel")
    sink = start()
    sink("prepare", {**TURTLE, "turtle2": "/turtle2/cmd_vel"})
    sink("wait")
    sink("send", "turtle2", 1, 0, 0, 0)
    gone.wait(lambda message: message["x"] == 1)
    fragile.kill()
    for speed in range(1, 200):  # many more than a publisher keeps until they are confirmed
        for robot in ("turtle2", "turtle1"):
            sink("send", robot, speed, 0, 0, 0)
        here.wait(at_speed(speed))
    sink.repeat(listen("/turtle2/cmd_vel"), "send", "turtle2", 0, 0, 0, 9)


@pytest.fixture
def halted(ros_python: str, alone: Mapping[str, str]) -> Iterator[Others]:
    """Other nodes that the test halts, with a long lease, so that they stay in the graph."""
    others = Others(ros_python, alone)
    yield others
    others.close()


def test_a_listener_that_is_found_but_hears_nothing_yet_is_waited_for(start: Start, halted: Others) -> None:
    """It is halted, so it hasn't found the publisher that has found it."""
    listener = Listener(halted, "/turtle1/cmd_vel", "/turtle2/cmd_vel")
    sink = start(**with_limits(outputs__ros__subscriber_check__ANSWER_LIMIT=1.0))
    sink("prepare", {"turtle2": "/turtle2/cmd_vel"})
    sink("wait")
    os.kill(halted.pid, signal.SIGSTOP)
    try:
        sink("prepare", TURTLE)
        assert sink("missing") == {"turtle1": ""}
        line = sink("find", "missing", "turtle1", "confirm")
        assert line.startswith("a listener on /turtle1/cmd_vel doesn't confirm that it hears anything: check whether ")
    finally:
        os.kill(halted.pid, signal.SIGCONT)
    sink("wait")
    sink("send", "turtle1", 0, 0, 0, 9)
    listener.wait(last)


def test_a_best_effort_listener_confirms_nothing_and_counts_after_a_while(sink: Sink, listen: Listen) -> None:
    listener = listen("/turtle1/cmd_vel", best_effort=True)
    sink("prepare", TURTLE)
    sink("wait")
    sink.repeat(listener, "send", "turtle1", 0, 0, 0, 9)


def test_publishers_are_kept_over_later_scores(sink: Sink, listen: Listen) -> None:
    listener = listen("/turtle1/cmd_vel", "/new/cmd_vel")
    sink("prepare", TURTLE)
    sink("wait")
    sink("prepare", {**TURTLE, "new": "/new/cmd_vel"})
    assert sink("missing").keys() <= {"new"}  # unless the sink has already found its listener
    sink("send", "turtle1", 1, 0, 0, 0)  # heard without waiting again
    sink("prepare", {"new": "/new/cmd_vel"})
    sink("wait")
    sink("send", "turtle1", 2, 0, 0, 0)  # a robot that no longer plays can still be stopped
    sink("send", "new", 0, 0, 0, 9)
    listener.wait(last)
    assert heard(listener) == [(1, 0, 0, 0), (2, 0, 0, 0)]
    assert heard(listener, "/new/cmd_vel") == [(0, 0, 0, 9)]


def test_a_robot_that_an_earlier_stage_moved_is_told_to_stop_as_soon_as_it_comes(sink: Sink, listen: Listen) -> None:
    sink("prepare", TURTLE, stops=True)
    sink("send", "turtle1", 0, 0, 0, 0)
    listener = listen("/turtle1/cmd_vel")
    sink.repeat(listener, "retry")
    assert all(map(still, listener.heard))


def test_a_score_that_takes_over_misses_no_listener(sink: Sink, listen: Listen) -> None:
    listener = listen("/turtle1/cmd_vel", "/new/cmd_vel")
    sink("prepare", TURTLE)
    sink("wait")
    sink("prepare", {**TURTLE, "new": "/new/cmd_vel"}, False)
    assert sink("missing") == {}
    sink("send", "new", 0, 0, 0, 9)
    listener.wait(last)


def test_signals_are_ours_and_the_last_zero_still_goes_out(start: Start, listen: Listen) -> None:
    listener = listen("/turtle1/cmd_vel")
    sink = start()
    sink("prepare", TURTLE)
    sink("wait")
    sink("send", "turtle1", 1, 0, 0, 0)
    sink.process.terminate()
    listener.wait(lambda message: message["x"] == 0)
    assert sink.process.wait(LIMIT) == 0


def test_robots_move_although_no_log_can_be_written(start: Start, listen: Listen) -> None:
    listener, sink = listen("/turtle1/cmd_vel"), start(ROS_LOG_DIR="/dev/null/log")
    sink("prepare", TURTLE)
    sink("wait")
    sink.repeat(listener, "send", "turtle1", 1, 0, 0, 0)


def test_the_environment_says_how_far_it_reaches(start: Start) -> None:
    """test_discovery.py tests the same for each release and each variable."""
    sink = start(ROS_DISTRO="humble", ROS_AUTOMATIC_DISCOVERY_RANGE="", ROS_LOCALHOST_ONLY="0", ROS_DOMAIN_ID="101")
    assert sink.description == "ROS 2, domain 101, this machine only"
