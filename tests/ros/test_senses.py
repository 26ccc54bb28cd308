"""Senses over ROS: real publishers of each message, and the edges that the stage's reader finds."""

from __future__ import annotations

import os
import signal
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from improv_core.score.senses import BuiltIn, Topic
from tests.processes import descendants, wait_until_gone
from tests.ros.conftest import (
    LIMIT,
    NOISE,
    SITE,
    Fields,
    Others,
    Publish,
    Publisher,
    Sink,
    Start,
    scan,
    with_code,
    with_limits,
)

pytestmark = pytest.mark.slow("processes of ROS find each other")

CMD = {"anna": "/anna/cmd_vel"}


@pytest.fixture
def sensor(publish: Publish) -> Publish:
    def start(topic: str, message: str) -> Publisher:
        return publish(topic, message, best_effort=True)

    return start


def read(sink: Sink, robots: dict[str, str] = CMD, **topics: Topic | BuiltIn) -> None:
    """Prepare a score with robots that read these senses."""
    sink("prepare", robots, senses={name: asdict(topic) for name, topic in topics.items()})


def feels(sink: Sink, *edges: list[Any]) -> None:
    """Wait for these edges, in any order. On a busy machine, a sensor may seem silent in between."""
    left = [*edges]
    while left:
        if (edge := sink("edge")) in left:
            left.remove(edge)


Each = tuple[Topic, Fields, Fields]
EACH: list[Each] = [
    (Topic("/anna/a", "sensor_msgs/LaserScan", 0.5, start=-0.5, end=0.5), scan(0.4), scan(0.6)),
    (
        Topic("/anna/b", "sensor_msgs/Range", below=0.5),
        {"range": 0.4, "min_range": 0.1, "max_range": 4.0},
        {"range": 0.6, "min_range": 0.1, "max_range": 4.0},
    ),
    (Topic("/anna/c", "sensor_msgs/Joy", button=1), {"buttons": [0, 1]}, {"buttons": [1, 0]}),
    (Topic("/anna/d", "std_msgs/Bool"), {"data": True}, {"data": False}),
    (Topic("/anna/e", "std_msgs/Float32", above=1.5), {"data": 2.0}, {"data": 1.0}),
    (Topic("/anna/f", "nav_msgs/Odometry", above=0.1), {"twist.twist.linear.x": -0.2}, {"twist.twist.angular.z": 0.2}),
]


def test_each_message_is_read(sensor: Publish, sink: Sink) -> None:
    """Each sense reads one message, all at the same time. test_readings.py tests malformed messages."""
    senses = {topic.topic[-1]: topic for topic, _, _ in EACH}
    sensors = {name: sensor(topic.topic, topic.message) for name, topic in senses.items()}
    read(sink, CMD, **senses)
    for value in (True, False, None, True):
        for topic, true, false in EACH:
            sensors[topic.topic[-1]]({True: true, False: false, None: None}[value])
        feels(sink, *(["anna", name, value] for name in senses))


def test_a_sensor_may_come_late_and_end(sensor: Publish, sink: Sink) -> None:
    """One topic falls silent, and the other has no timeout: it is silent while nobody publishes."""
    read(sink, drop=Topic("/anna/drop", "std_msgs/Bool"), hit=Topic("/anna/drop", "std_msgs/Bool", timeout=0.0))
    stands = "so anna stands still where it reads `drop`"
    assert sink("find", "warnings", "anna", "nobody") == f"nobody publishes on /anna/drop, {stands}"
    publish = sensor("/anna/drop", "std_msgs/Bool")
    assert sink("find", "warnings", "anna", "usable") == f"nothing usable comes on /anna/drop, {stands}"
    feels(sink, ["anna", "hit", False])  # somebody could publish, but has not yet
    publish({"data": True})
    feels(sink, ["anna", "drop", True], ["anna", "hit", True])
    sink("until_no_warnings")
    publish.close()
    feels(sink, ["anna", "drop", None], ["anna", "hit", None])


def test_a_killed_sensor_is_silent_until_another_one_comes(fragile: Others, sensor: Publish, start: Start) -> None:
    """The graph contains it until its lease ends."""
    sink, publish = start(), Publisher(fragile, "/anna/drop", "std_msgs/Bool")
    read(sink, hit=Topic("/anna/drop", "std_msgs/Bool", timeout=0.0))
    publish({"data": True})
    feels(sink, ["anna", "hit", True])
    fragile.kill()
    feels(sink, ["anna", "hit", None])
    sensor("/anna/drop", "std_msgs/Bool")({"data": True})
    feels(sink, ["anna", "hit", True])


def test_beat_0_waits_for_a_sensor(sensor: Publish, sink: Sink) -> None:
    sensor("/anna/drop", "std_msgs/Bool")({"data": True})
    read(sink, drop=Topic("/anna/drop", "std_msgs/Bool"))
    sink("wait_for_reset")
    assert sink("edge") == ["anna", "drop", True]


def test_a_reader_that_ends_is_replaced(sensor: Publish, start: Start) -> None:
    sink = start(**with_limits(outputs__ros__sensors__client__AGAIN=3.0))  # the line about its end stays until then
    sensor("/anna/scan", "sensor_msgs/LaserScan")(scan(0.4))
    read(sink, near=Topic("/anna/scan", "sensor_msgs/LaserScan", 0.5))
    feels(sink, ["anna", "near", True])
    (reader,) = descendants(sink.process.pid)
    os.kill(reader, signal.SIGKILL)
    feels(sink, ["anna", "near", None])
    line = "the process that reads sensors has ended: another one starts"
    sink("find", "warnings", line, line)
    feels(sink, ["anna", "near", True])
    sink("until_no_warnings")
    assert reader not in descendants(sink.process.pid)


def test_the_output_of_libraries_harms_no_helper_process(sensor: Publish, start: Start) -> None:
    """It harms neither the standby nor the reader."""
    sink = start("standby", **{**with_limits(), **with_code(NOISE)})
    sensor("/anna/drop", "std_msgs/Bool")({"data": True})
    read(sink, drop=Topic("/anna/drop", "std_msgs/Bool"))
    feels(sink, ["anna", "drop", True])
    sink("until_ready")
    sink("until_no_warnings")


def test_a_stage_that_is_killed_takes_its_reader_along(publish: Publish, start: Start) -> None:
    sink = start()
    read(sink, cue=BuiltIn("cue"))
    assert descendants(sink.process.pid) == {}, "a program without senses starts no reader"
    publish("/anna/hit", "std_msgs/Bool")
    read(sink, hit=Topic("/anna/hit", "std_msgs/Bool", timeout=0.0))
    feels(sink, ["anna", "hit", False])
    reader = descendants(sink.process.pid)
    sink.process.kill()
    wait_until_gone(reader, LIMIT)


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        (BuiltIn("near"), "no topic provides `sense` for real robots: add [senses.sense] to improv.toml"),
        (
            Topic("/anna/other", "std_msgs/Bool"),
            "/anna/other carries std_msgs/msg/Float32, not std_msgs/msg/Bool, so anna stands still where it reads",
        ),
    ],
)
def test_an_unreadable_sense_is_reported(source: Topic | BuiltIn, expected: str, sensor: Publish, sink: Sink) -> None:
    sensor("/anna/other", "std_msgs/Float32")
    read(sink, sense=source)
    assert sink("find", "warnings", "anna", expected).startswith(expected)


def test_a_second_type_on_one_topic_is_reported(sink: Sink) -> None:
    """Fast DDS refuses it; the stage still reads the first one."""
    read(sink, one=Topic("/anna/x", "std_msgs/Bool"), two=Topic("/anna/x", "std_msgs/Float32", below=1.0))
    assert "/anna/x can't be read as std_msgs/" in sink("find", "warnings", "anna", "can't be read")


def test_a_missing_message_package_is_reported(start: Start, tmp_path: Path) -> None:
    (tmp_path / "nav_msgs.py").write_text("raise ImportError\n")
    sink = start(PYTHONPATH=f"{tmp_path}:{SITE}")
    read(sink, moves=Topic("/anna/odom", "nav_msgs/Odometry", above=0.0))
    line = sink("find", "warnings", "anna", "can't import")
    assert "can't import nav_msgs, so /anna/odom can't be read: install nav_msgs, so anna stands still" in line
