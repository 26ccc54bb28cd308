"""The clock of the time in a stamp, and the time of a simulation that a dance follows."""

from __future__ import annotations

import time
from threading import Event, Thread

import pytest

from tests.ros.conftest import LIMIT, STAMPED, Listen, Publish, Sink, Start
from tests.ros.dance import moving

pytestmark = pytest.mark.slow("processes of ROS find each other")

TOPIC = "/turtle1/cmd_vel"
TURTLE = {"turtle1": TOPIC}
SIMULATED = {"clock.sec": 12, "clock.nanosec": 500_000_000}


def test_stamps_come_from_this_machine_and_an_unused_clock_is_reported(
    start: Start, listen: Listen, publish: Publish
) -> None:
    robot = listen(TOPIC, type=STAMPED)
    sink = start("--ros-args", "-r", "/clock:=/lab/clock")
    sink("prepare", TURTLE)
    sink("wait")
    before = time.time()
    sink("send", "turtle1", 1, 0, 0, 0)
    assert before <= robot.wait(moving)["stamp"] <= time.time()
    publish("/lab/clock", "rosgraph_msgs/Clock")(SIMULATED)
    line = sink("find", "warnings", "turtle1", "/clock")
    assert line.endswith("if the robot is simulated, set `use_sim_time = true` under [ros] in improv.toml")
    sink("prepare", TURTLE, use_sim_time=True)
    assert sink("warnings") == {}


def test_stamps_come_from_the_simulation(sink: Sink, listen: Listen, publish: Publish) -> None:
    robot = listen(TOPIC, type=STAMPED)
    sink("prepare", TURTLE, use_sim_time=True)
    line = f"no time has arrived on /clock, so messages on {TOPIC} are stamped 0: start the simulation"
    assert sink("find", "missing", "turtle1", "/clock") == line
    publish("/clock", "rosgraph_msgs/Clock")(SIMULATED)
    sink("wait")
    sink("send", "turtle1", 1, 0, 0, 0)
    assert robot.wait(moving)["stamp"] == 12.5
    sink("prepare", TURTLE)
    sink("send", "turtle1", 2, 0, 0, 0)
    assert robot.wait(lambda message: message["x"] == 2)["stamp"] > 1e9, "and again of this machine"


def test_a_robot_that_takes_no_stamps_needs_no_clock(sink: Sink, listen: Listen) -> None:
    listen(TOPIC)
    sink("prepare", TURTLE, use_sim_time=True)
    sink("wait")


def test_the_time_of_a_simulation_that_a_dance_follows_is_known(sink: Sink, publish: Publish) -> None:
    """tests/player/test_following_clock.py tests the effects."""
    sink("prepare", TURTLE, follows_time=True)
    clock, known = publish("/clock", "rosgraph_msgs/Clock"), Event()
    begun = time.monotonic()

    def simulate() -> None:
        while not known.is_set():
            passed = (time.monotonic() - begun) / 2
            clock({"clock.sec": int(passed), "clock.nanosec": int(passed % 1 * 1e9)}, once=True)

    running = Thread(target=simulate)
    running.start()
    try:
        while sink("rate") != pytest.approx(0.5, abs=0.1):  # on a busy machine, it takes a while
            assert time.monotonic() < begun + LIMIT
    finally:
        known.set()
        running.join()
