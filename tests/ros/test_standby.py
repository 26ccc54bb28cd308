"""A stage that can no longer stop its robots: its standby does, and another one replaces a lost standby.

outputs/test_standby_*.py test the times; here only a sink's standby could stop a robot.
"""

from __future__ import annotations

import os
import signal
from typing import Any

import pytest

from improv_core.outputs.ros.subscriber_check import ZEROS
from improv_core.safety.pending_zeros import PERIOD
from tests.processes import descendants, wait_until_gone
from tests.ros.conftest import LIMIT, STAMPED, Listen, Listener, Publish, Sink, Start, with_limits
from tests.ros.dance import at_speed, still

pytestmark = pytest.mark.slow("starts processes to end them")

TOPICS = ("/turtle1/cmd_vel", "/turtle2/cmd_vel")
ASKED = 2 * ZEROS
"""Most messages that may still wait for a subscriber that the stage asked twice."""


@pytest.fixture
def sink(start: Start) -> Sink:
    return start("standby")


def moving(listen: Listen, sink: Sink) -> Listener:
    """Make one robot move and another stand. Return a subscriber that hears both."""
    turtles = listen(*TOPICS)
    sink("prepare", {"turtle1": TOPICS[0], "turtle2": TOPICS[1]})
    sink("wait")
    turtles.wait(lambda message: message["topic"] == TOPICS[1])
    for _ in range(ASKED):  # a subscriber reads its topics in turns: now no message waits for the robot that stands
        moves(turtles, sink)
    turtles.hear_all()
    turtles.heard = [message for message in turtles.heard if not still(message)]  # they only checked that it hears
    return turtles


def moves(turtles: Listener, sink: Sink, speed: float = 1.0) -> None:
    sink("send", "turtle1", speed, 0.0, 0.0, 0.0)
    turtles.wait(lambda message: message["x"] == speed)


def test_a_stage_that_is_halted_is_killed(listen: Listen, start: Start) -> None:
    """The standby kills it long before its silence lasts too long."""
    sink = start("standby", **with_limits(protocol__limits__HANG_LIMIT=2 * LIMIT))
    turtles = moving(listen, sink)
    standby = descendants(sink.process.pid)
    os.kill(sink.process.pid, signal.SIGSTOP)
    turtles.wait(still)
    wait_until_gone(standby, LIMIT)
    assert sink.process.wait(LIMIT) == -signal.SIGKILL
    turtles.close()
    assert {message["topic"] for message in turtles.heard if still(message)} == {TOPICS[0]}, (
        "turtle2 is not ours to move"
    )


def test_the_standby_stops_robots_that_have_not_confirmed_a_stop(listen: Listen, sink: Sink) -> None:
    """It sends many zeros at once, so that DDS asks for a confirmation: others may soon move the robot."""
    turtles = moving(listen, sink)
    sink("send", "turtle1", 0.0, 0.0, 0.0, 0.0)
    turtles.wait(still)
    ours = descendants(sink.process.pid)
    before = len(turtles.heard)
    sink.process.kill()
    turtles.wait(still)
    wait_until_gone(ours, LIMIT)
    turtles.close()
    assert {message["topic"] for message in turtles.heard} == {TOPICS[0]}
    first, *others = [message["at"] for message in turtles.heard[before:][: ZEROS // 2]]
    assert others
    assert others[-1] - first < PERIOD * len(others), "sooner after each other than when they are sent again"


def test_the_standby_leaves_robots_alone_that_confirmed_a_stop(listen: Listen, publish: Publish, sink: Sink) -> None:
    turtles = moving(listen, sink)
    sink("send", "turtle1", 0.0, 0.0, 0.0, 0.0)
    sink("until_no_zero_pends")
    publish(TOPICS[0], "geometry_msgs/Twist")({"linear.x": 9.0})
    turtles.wait(at_speed(9))  # a subscriber reads a topic in order, so all confirmed messages came before this one
    assert any(map(still, turtles.heard))
    ours = descendants(sink.process.pid)
    before = len(turtles.heard)
    sink.process.kill()
    wait_until_gone(ours, LIMIT)
    turtles.close()
    assert not any(map(still, turtles.heard[before:]))


def test_the_standby_stops_a_robot_if_the_stage_ends_while_it_moves(listen: Listen, sink: Sink) -> None:
    """The standby lets the stage end by itself, so its last message is not lost."""
    turtles = moving(listen, sink)
    sink.close()
    turtles.wait(still)
    assert sink.process.returncode == 0


def test_zeros_of_the_standby_have_the_time_of_the_simulation(listen: Listen, publish: Publish, sink: Sink) -> None:
    robot = listen(TOPICS[0], type=STAMPED)
    publish("/clock", "rosgraph_msgs/Clock")({"clock.sec": 12})
    sink("prepare", {"turtle1": TOPICS[0]}, use_sim_time=True)
    sink("wait")
    sink("send", "turtle1", 1.0, 0.0, 0.0, 0.0)
    sink("advance", 0.0)
    robot.wait(at_speed(1.0))
    sink.process.kill()
    assert 12 <= robot.wait(still)["stamp"] < 12 + LIMIT


def test_a_standby_that_is_lost_is_replaced_while_robots_move(listen: Listen, sink: Sink) -> None:
    """The dance keeps playing, and the new one stops the robots when the stage is killed."""
    turtles = moving(listen, sink)
    (standby,) = before = descendants(sink.process.pid)
    os.kill(standby, signal.SIGKILL)
    line = "the standby process has ended: another one starts"
    assert sink("find", "warnings", line, line) == line
    wait_until_gone(before, LIMIT)
    sink("until_ready")
    now = descendants(sink.process.pid)
    assert standby not in now
    moves(turtles, sink, 2.0)
    assert not any(map(still, turtles.heard))
    sink.process.kill()
    turtles.wait(still)
    wait_until_gone(now, LIMIT)


def test_two_stages_on_one_robot_name_each_other(listen: Listen, start: Start) -> None:
    """They don't name each other's standby."""
    turtle = {"turtle1": TOPICS[0]}
    sinks: list[Any] = [start("standby"), start("standby")]
    listen(TOPICS[0])
    for sink in sinks:
        sink("prepare", turtle)
    for sink, other in (sinks, sinks[::-1]):
        line = sink("find", "warnings", "turtle1", "other nodes")
        assert line.startswith(f"other nodes also publish to {TOPICS[0]}: /improv_")
        assert f"_{other.process.pid}; robots obey all of them" in line
