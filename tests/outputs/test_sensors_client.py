"""The stage's side of the process that reads sensors. A script replaces that process, so no ROS is needed."""

from __future__ import annotations

import os
import queue
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from improv_core.outputs.ros.sensors import client
from improv_core.outputs.ros.sensors.client import PROMPT, USUAL, RosReader, request_for
from improv_core.protocol.output import Edge, RawJoints, RawPoses
from improv_core.protocol.reader_messages import Read
from improv_core.score.motion import Pose
from improv_core.score.profiles import TURTLESIM
from improv_core.score.score import Part
from improv_core.score.senses import RobotSense, Topic
from tests.processes import command_of, descendants
from tests.waiting import until

LIMIT = 60.0
ANNA = RobotSense("anna", "bump")
EDGE = '{"type": "edge", "robot": "anna", "sense": "bump", "value": false, "at": 1.0}'


def wanted(period: float = USUAL, **part: Any) -> Read:
    """Return the request to read this for anna's part."""
    return request_for({"anna": Part("anna", (), TURTLESIM, Pose(), "/anna/cmd_vel", **part)}, period)


@contextmanager
def reading(
    monkeypatch: pytest.MonkeyPatch, script: str
) -> Iterator[tuple[RosReader, queue.SimpleQueue[Edge | RawPoses | RawJoints]]]:
    """A reader whose process runs a script, and everything that it passes on."""
    heard: queue.SimpleQueue[Edge | RawPoses | RawJoints] = queue.SimpleQueue()
    monkeypatch.setattr(client, "helper_command", lambda name, *arguments: [sys.executable, "-c", script])
    reader = RosReader("node", (), heard.put, time.monotonic)
    reader.read(wanted(senses={"bump": Topic("/anna/bump", "std_msgs/Bool")}))
    try:
        yield reader, heard
    finally:
        reader.close()
        # Others may exist at any time: those of the browser, which all tests of a worker share.
        left = [pid for pid in descendants(os.getpid()) if script.encode() in command_of(pid)]
        assert left == [], "no process is left"


@pytest.mark.parametrize("line", ["[WARN] [reader]: a line of some library", '{"type": "edge"}', "[]"])
def test_an_unreadable_line_makes_all_senses_unknown(monkeypatch: pytest.MonkeyPatch, line: str) -> None:
    with reading(monkeypatch, f"print({EDGE!r}, flush=True); print({line!r}, flush=True); input()") as (reader, heard):
        assert heard.get(timeout=LIMIT) == Edge(ANNA, False, 1.0)
        silent = heard.get(timeout=LIMIT)
        assert isinstance(silent, Edge)
        assert (silent.what, silent.value) == (ANNA, None)
        assert reader.is_silent(ANNA)


FROZEN = f"""\
import sys, time
ALIVE = '{{"type": "alive"}}\\n'
print(ALIVE + {EDGE!r} + "\\n" + ALIVE, end="", flush=True)
sys.stdin.readline()  # what to read
sys.stdin.readline()
"""
"""It sends an edge, and then hangs for good."""


def test_a_process_that_stays_frozen_is_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(client, "ALIVE_LIMIT", 0.5)
    monkeypatch.setattr(client, "AGAIN", LIMIT)  # so that the problem stays
    with reading(monkeypatch, FROZEN) as (reader, _):
        until(lambda: reader.problem)
        assert reader.problem == "the process that reads sensors was silent for 0.5 s: another one starts"


AWAKE = f"""\
import os, sys, time
ALIVE = '{{"type": "alive"}}\\n'
print(ALIVE + {EDGE!r}, flush=True)
while not os.path.exists("GATE"):
    time.sleep(0.01)
print(ALIVE + {EDGE!r}.replace("false", "true"), flush=True)
while True:
    print(ALIVE, end="", flush=True)
    time.sleep(0.05)
"""
"""It sends an edge, and then nothing until a file exists."""


def test_a_process_that_resumes_counts_again_once_it_has_caught_up(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Its messages from before it hung may no longer be true."""
    monkeypatch.setattr(client, "ALIVE_LIMIT", LIMIT)
    gate = tmp_path / "gate"
    with reading(monkeypatch, AWAKE.replace("GATE", str(gate))) as (_, heard):
        edges = [heard.get(timeout=LIMIT) for _ in range(2)]
        gate.touch()
        edges.append(heard.get(timeout=LIMIT))
        assert [edge.value for edge in edges if isinstance(edge, Edge)] == [False, None, True]


POSES = """\
import json, sys
pose = {"robot": "anna", "source": "nav_msgs/Odometry", "frame": "odom", "at": 1.0, "stamp": None}
pose["pose"] = {"x": 0, "y": 0, "z": 0, "heading": 0}
while "/anna/odom" not in sys.stdin.readline():
    pass
for topic in ("/anna/before", "/anna/odom"):
    print(json.dumps({"type": "poses", "poses": [pose | {"topic": topic}]}), flush=True)
sys.stdin.readline()
"""
"""After the request for the poses on a topic, poses of another topic come first."""


def test_a_pose_from_a_topic_that_no_longer_counts_is_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    with reading(monkeypatch, POSES) as (reader, heard):
        reader.read(wanted(odom="/anna/odom"))
        found = heard.get(timeout=LIMIT)
        assert isinstance(found, RawPoses)
        assert [pose.topic for pose in found.poses] == ["/anna/odom"]


@pytest.mark.parametrize(("period", "urgent"), [(USUAL, False), (PROMPT, True)])
def test_poses_are_as_urgent_as_commands_if_robots_have_to_keep_apart(
    period: float, urgent: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    started: queue.SimpleQueue[list[str]] = queue.SimpleQueue()

    def start(command: list[str], policy: object) -> None:
        started.put(command)
        raise OSError("not in this test")

    monkeypatch.setattr(client, "Child", start)
    reader = RosReader("node", (), lambda heard: None, time.monotonic)
    reader.read(wanted(period, odom="/anna/pose"))
    assert ("prompt" in started.get(timeout=LIMIT)) == urgent
    reader.close()


@pytest.mark.parametrize(
    ("story", "waits"),
    [
        ("alive", [True, True, False]),
        ("alive published", [True, True, True, True, False]),
        ("published", [True, True, True, True, False]),  # the process has yet to start
        ("alive bert published", [True, True, True, True, False]),
        ("alive bert anna published", [False]),
    ],
)
def test_beat_0_waits_longer_for_poses_that_are_published_than_for_missing_ones(story: str, waits: list[bool]) -> None:
    now, topics = 100.0, {"anna": "/anna/amcl_pose", "bert": "/bert/amcl_pose"}
    reader = RosReader("node", (), lambda heard: None, lambda: now)
    reader._thread = threading.Thread(target=lambda: None)  # no process
    reader.read({**wanted(), "odometry": topics})
    for word in story.split():
        if word == "alive":
            reader._take({"type": "alive"})
        elif word in topics:
            pose: Any = {"robot": word, "source": "", "frame": "map", "at": now, "stamp": None, "topic": topics[word]}
            pose["pose"] = {"x": 0, "y": 0, "z": 0, "heading": 0}
            reader._take({"type": "poses", "poses": [pose]})
    found, lines = list[bool](), list[str]()
    while not found or found[-1]:
        found.append(reader.under_way(lambda topic: "published" in story))
        if found[-1] and (line := reader.slowness()):
            lines.append(line)
        now += 3 if len(found) < 3 else 7
    assert found == waits
    robots = "bert" if "anna" in story else "anna" if "bert" in story else "anna and bert"
    assert lines == ([f"waiting for poses of {robots}"] if len(waits) > 3 else [])
