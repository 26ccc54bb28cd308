"""Buttons that people press while robots move: real publishers of an emergency stop and of a gamepad.

tests/safety (test_interlocks.py), tests/player, tests/stage, and tests/session test the effects on robots.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.ros.conftest import Listen, Publish, Publisher, Sink, Start, with_limits
from tests.ros.dance import AFTER, AFTER_SPEED, Server, at_speed, dances, moving, still

pytestmark = pytest.mark.slow("processes of ROS find each other")

TURTLE = {"turtle1": "/turtle1/cmd_vel"}
STOP = "std_msgs/Bool"
ON, OFF = {"data": True}, {"data": False}
HELD, LOOSE = {"buttons": [0, 0, 0, 0, 1]}, {"buttons": [0, 0, 0, 0, 0]}
BUTTON = "button 4 on /joy"


def test_an_emergency_stop_stops_robots_until_a_save_after_its_release(
    publish: Publish, listen: Listen, ros_env: Mapping[str, str], tmp_path: Path
) -> None:
    """Its publisher is best effort, the kind that is hardest to hear."""
    turtle, stop = listen("/turtle1/cmd_vel"), publish("/e_stop", STOP, best_effort=True)
    (tmp_path / "improv.toml").write_text('[ros]\nstop = "/e_stop"\n')
    with Server(ros_env, uri=(tmp_path / "dance.improv").as_uri()) as conductor:
        dances(conductor, turtle)
        stop(ON)
        turtle.wait(still)
        conductor.wait_for_line("the emergency stop on /e_stop is on, so all robots were stopped")
        conductor.type(AFTER)
        conductor.client.save(conductor.uri)
        conductor.wait_for_line("✗ the emergency stop on /e_stop is on: release it, then save again")
        stop(OFF)
        conductor.wait_for_line("the emergency stop on /e_stop is off: play again")
        turtle.hear_all()
        conductor.save(AFTER)
        moves = turtle.wait(moving)
        assert at_speed(AFTER_SPEED)(moves), "nothing has moved before"


def stops(sink: Sink, value: bool) -> None:
    assert sink("edge") == ["/e_stop", value]


@pytest.mark.parametrize("kind", ["latched", "reliable", "best_effort"])
def test_emergency_stops_of_each_kind_are_heard(kind: str, publish: Publish, sink: Sink) -> None:
    """A latched one may be on before the stage listens: beat 0 waits for its value."""
    sinks_first = kind != "latched"
    if sinks_first:
        sink("prepare", TURTLE, stop="/e_stop")
    stop = publish("/e_stop", STOP, **({} if kind == "reliable" else {kind: True}))
    if sinks_first:
        stop(ON)
    else:
        stop(ON, once=True)
        sink("prepare", TURTLE, stop="/e_stop")
        sink("wait_for_reset")
    stops(sink, True)
    stop(OFF)
    stops(sink, False)


def test_each_press_stops_although_another_publisher_keeps_sending_false(publish: Publish, start: Start) -> None:
    sink = start(**with_limits(safety__interlocks__RELEASED=0.0))
    publish("/e_stop", STOP, hz=100)(OFF)
    press = publish("/e_stop", STOP)
    sink("prepare", TURTLE, stop="/e_stop")
    sink("wait_for_reset")
    stops(sink, False)
    for _ in range(15):
        press(ON, once=True)
        stops(sink, True)
        stops(sink, False)


def test_the_sink_listens_to_an_emergency_stop_that_no_score_names(publish: Publish, sink: Sink) -> None:
    """An earlier stage has heard that it is on."""
    stop = publish("/e_stop", STOP)
    sink("guard", ["/e_stop"])
    sink("prepare", TURTLE)
    stop(OFF)
    stops(sink, False)


def test_a_source_without_a_publisher_is_named(sink: Sink) -> None:
    sink("prepare", TURTLE, stop="/e_stop", deadman=["/joy", 4])
    assert sink("find", "warnings", "/e_stop", "") == (
        "nobody publishes on /e_stop, so the emergency stop there stops nothing"
    )
    assert sink("find", "warnings", "/joy", "") == "nobody publishes on /joy, so robots wait for it"


@pytest.fixture
def joy(publish: Publish) -> Publisher:
    return publish("/joy", "sensor_msgs/Joy", hz=50)


def holds(sink: Sink, value: bool | None) -> None:
    """Wait for this value. On a busy machine, the button may seem silent in between."""
    while sink("edge") != [BUTTON, value]:
        pass


def test_a_deadman_button_that_is_held_released_and_silent(joy: Publisher, sink: Sink) -> None:
    sink("prepare", TURTLE, deadman=["/joy", 4])
    for fields, value in ((HELD, True), (LOOSE, False), (HELD, True), (None, None)):
        joy(fields)
        holds(sink, value)


def test_a_held_button_counts_only_while_no_other_gamepad_denies_it(
    joy: Publisher, publish: Publish, sink: Sink
) -> None:
    another = publish("/joy", "sensor_msgs/Joy", hz=50)
    sink("prepare", TURTLE, deadman=["/joy", 4])
    joy(HELD)
    holds(sink, True)
    another(LOOSE)
    holds(sink, False)
    another(None)
    holds(sink, True)


def test_a_stage_that_can_no_longer_hear_a_button_raises_an_alarm(joy: Publisher, publish: Publish, sink: Sink) -> None:
    """With an alarm, a stage stops its robots and ends: test_loop.py."""
    sink("prepare", TURTLE, deadman=["/joy", 4], use_sim_time=True)
    joy(HELD)
    holds(sink, True)
    publish("/clock", "rosgraph_msgs/Clock")({"clock.sec": -1})
    line = sink("alarm")
    assert line.startswith("a message from ROS 2 can't be handled (Seconds value must not be ")
