"""Senses over ROS: real publishers of each message, and what the stage's reader makes of them."""

from __future__ import annotations

import math
import os
import signal
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest

from improv_core.score.senses import BuiltIn, Topic
from tests.processes import descendants, wait_until_gone
from tests.ros.conftest import LIMIT, SCAN, Sense, Sink, scan

CMD = {"anna": "/anna/cmd_vel"}


def read(sink: Sink, cast: dict[str, str] = CMD, **topics: Topic | BuiltIn) -> None:
    """A score with robots that read these senses."""
    sink("prepare", cast, senses={name: asdict(topic) for name, topic in topics.items()})


def feels_all(sink: Sink, *edges: list[Any]) -> None:
    """These are the next edges, in any order."""
    found = [sink("edge")[0] for _ in edges]
    assert all(edge in found for edge in edges), found


def feels(sink: Sink, *edges: list[Any]) -> None:
    """These are the next edges."""
    assert [sink("edge")[0] for _ in edges] == list(edges)


def test_each_message(sensor: Sense, sink: Sink) -> None:
    for topic, true, false in [
        (Topic("/anna/a", "sensor_msgs/LaserScan", 0.5, start=-0.5, end=0.5), scan(0.4), scan(0.6)),
        (
            Topic("/anna/b", "sensor_msgs/Range", below=0.5),
            {"range": 0.4, "min_range": 0.1, "max_range": 4.0},
            {"range": 0.6, "min_range": 0.1, "max_range": 4.0},
        ),
        (Topic("/anna/c", "sensor_msgs/Joy", button=1), {"buttons": [0, 1]}, {"buttons": [1, 0]}),
        (Topic("/anna/d", "std_msgs/Bool"), {"data": True}, {"data": False}),
        (Topic("/anna/e", "std_msgs/Float32", above=1.5), {"data": 2.0}, {"data": 1.0}),
        (
            Topic("/anna/f", "nav_msgs/Odometry", above=0.1),
            {"twist.twist.linear.x": -0.2},
            {"twist.twist.angular.z": 0.2},
        ),
    ]:
        publish = sensor(topic.topic, topic.message)
        read(sink, sense=topic)
        for value in (True, False, True):
            publish(true if value else false)
            feels(sink, ["anna", "sense", value])
        publish(None)
        feels(sink, ["anna", "sense", None])
        assert sink("no_more_edges")


HOSTILE = [
    {**SCAN, "ranges": []},
    {**SCAN, "ranges": [math.nan] * 360},
    {**scan(0.4), "angle_increment": 0.0},
    {**scan(0.4), "angle_increment": math.nan},
    {**scan(0.4), "angle_min": math.inf},
    {**scan(0.4), "ranges": [0.4] * 100_000},
    {**scan(0.4), "range_min": math.inf},
]


def test_scans_that_no_sensor_should_send(sensor: Sense, sink: Sink) -> None:
    """They say nothing: whoever sends only these is silent, and is heard again afterward."""
    publish = sensor("/anna/scan", "sensor_msgs/LaserScan")
    read(sink, near=Topic("/anna/scan", "sensor_msgs/LaserScan", 0.5, start=-0.5, end=0.5, timeout=0.5))
    for wrong in HOSTILE:
        publish(scan(0.4))
        feels(sink, ["anna", "near", True])
        publish(wrong)
        feels(sink, ["anna", "near", None])


def test_several_senses_of_several_robots_on_one_topic(sensor: Sense, sink: Sink) -> None:
    publish = sensor("/scan", "sensor_msgs/LaserScan")
    cast = {**CMD, "bert": "/bert/cmd_vel"}
    near, far = (Topic("/scan", "sensor_msgs/LaserScan", limit) for limit in (0.5, 2.0))
    read(sink, cast, near=near, far=far)
    publish(scan(1.0))
    came = sorted(sink("edge")[0] for _ in range(4))
    assert came == [["anna", "far", True], ["anna", "near", False], ["bert", "far", True], ["bert", "near", False]]
    read(sink, CMD, near=near)
    came = sorted(sink("edge")[0] for _ in range(3))
    assert came == [["anna", "far", None], ["bert", "far", None], ["bert", "near", None]]
    publish(scan(0.4))
    feels(sink, ["anna", "near", True])
    read(sink)
    feels(sink, ["anna", "near", None])
    read(sink, far=far)
    feels(sink, ["anna", "far", True])


def test_a_sensor_that_comes_late(sensor: Sense, sink: Sink) -> None:
    read(sink, drop=Topic("/anna/drop", "std_msgs/Bool"))
    stands = "so anna stands still where it reads `drop`"
    assert sink("find", "warnings", "anna", "nobody") == f"nobody publishes on /anna/drop, {stands}"
    publish = sensor("/anna/drop", "std_msgs/Bool")
    assert sink("find", "warnings", "anna", "usable") == f"nothing usable comes on /anna/drop, {stands}"
    publish({"data": True})
    feels(sink, ["anna", "drop", True])
    sink("until_no_warnings")


def test_beat_0_waits_for_a_sensor(sensor: Sense, sink: Sink) -> None:
    publish = sensor("/anna/drop", "std_msgs/Bool")
    publish({"data": True})
    read(sink, drop=Topic("/anna/drop", "std_msgs/Bool"))
    sink("wait_for_reset")
    assert not sink("no_more_edges")


@pytest.mark.parametrize("killed", [False, True], ids=["ended", "killed"])
def test_a_sensor_that_ends(killed: bool, sensor: Sense, sink: Sink) -> None:
    publish = sensor("/anna/drop", "std_msgs/Bool")
    drop, hit = (Topic("/anna/drop", "std_msgs/Bool", timeout=timeout) for timeout in (0.5, 0.0))
    read(sink, drop=drop, hit=hit)
    feels(sink, ["anna", "hit", False])  # somebody could publish, but has not yet
    publish({"data": True})
    feels_all(sink, ["anna", "drop", True], ["anna", "hit", True])
    if killed:
        publish.process.kill()  # then the graph shows it until its lease ends
    publish.process.communicate()
    feels_all(sink, ["anna", "drop", None], ["anna", "hit", None])
    again = sensor("/anna/drop", "std_msgs/Bool")
    again({"data": True})
    came = [sink("edge")[0] for _ in range(2)]
    if came[0] == ["anna", "hit", False]:
        came = [*came[1:], sink("edge")[0]]
    assert sorted(came) == [["anna", "drop", True], ["anna", "hit", True]]


def test_a_sensor_that_sends_only_changes(sensor: Sense, sink: Sink) -> None:
    publish = sensor("/anna/hit", "std_msgs/Bool")
    read(
        sink,
        hit=Topic("/anna/hit", "std_msgs/Bool", timeout=0.0),
        bump=Topic("/anna/hit", "std_msgs/Bool", timeout=0.3),
    )
    feels(sink, ["anna", "hit", False])
    publish({"data": True}, once=True)
    came = sorted(sink("edge")[0] for _ in range(2))
    assert came == [["anna", "bump", True], ["anna", "hit", True]]
    feels(sink, ["anna", "bump", None])
    assert sink("no_more_edges")


@pytest.mark.parametrize(
    ("how", "what"), [(signal.SIGKILL, "has ended"), (signal.SIGSTOP, "was silent for 1.0 s")], ids=["killed", "halted"]
)
def test_a_reader_that_fails(how: int, what: str, sensor: Sense, sink: Sink) -> None:
    publish = sensor("/anna/scan", "sensor_msgs/LaserScan")
    publish(scan(0.4))
    read(sink, near=Topic("/anna/scan", "sensor_msgs/LaserScan", 0.5))
    feels(sink, ["anna", "near", True])
    (reader,) = descendants(sink.process.pid)
    os.kill(reader, how)
    feels(sink, ["anna", "near", None])
    line = f"the process that reads sensors {what}: another one starts"
    sink("find", "warnings", line, line)
    feels(sink, ["anna", "near", True])
    assert sink("warnings") == {}
    (another,) = descendants(sink.process.pid)
    assert another != reader


def test_a_stage_that_is_killed_takes_its_reader_along(sensor: Sense, sink: Sink) -> None:
    sensor("/anna/hit", "std_msgs/Bool")
    read(sink, hit=Topic("/anna/hit", "std_msgs/Bool", timeout=0.0))
    feels(sink, ["anna", "hit", False])
    reader = descendants(sink.process.pid)
    sink.process.kill()
    wait_until_gone(reader, LIMIT)


def test_a_program_without_senses_starts_no_reader(sink: Sink) -> None:
    read(sink, cue=BuiltIn("cue"))
    assert descendants(sink.process.pid) == {}
    assert sink("warnings") == {}


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        (BuiltIn("near"), "no topic says when `sense` is true of real robots: add [senses.sense] to improv.toml"),
        (
            Topic("/anna/other", "std_msgs/Bool"),
            "/anna/other carries std_msgs/msg/Float32, not std_msgs/Bool, so anna stands still where it reads `sense`",
        ),
    ],
)
def test_a_sense_that_can_not_be_read(source: Topic | BuiltIn, expected: str, sensor: Sense, sink: Sink) -> None:
    sensor("/anna/other", "std_msgs/Float32")
    read(sink, sense=source)
    assert sink("find", "warnings", "anna", expected).startswith(expected)


def test_two_types_on_one_topic(sink: Sink) -> None:
    """Fast DDS refuses that; the first one is read all the same."""
    read(sink, one=Topic("/anna/x", "std_msgs/Bool"), two=Topic("/anna/x", "std_msgs/Float32", below=1.0))
    assert "/anna/x can't be read as std_msgs/" in sink("find", "warnings", "anna", "can't be read")


def test_a_message_that_is_missing(start: Callable[..., Sink], tmp_path: Path) -> None:
    (tmp_path / "nav_msgs.py").write_text("raise ImportError\n")
    sink = start(PYTHONPATH=str(tmp_path))
    read(sink, moves=Topic("/anna/odom", "nav_msgs/Odometry", above=0.0))
    line = sink("find", "warnings", "anna", "can't import")
    assert "can't import nav_msgs, so /anna/odom can't be read: install nav_msgs, so anna stands still" in line
