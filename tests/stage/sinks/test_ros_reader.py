"""The stage's side of the process that reads sensors. That process is a script here: it needs no ROS."""

from __future__ import annotations

import queue
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from improv_core.score.senses import RobotSense, Topic
from improv_core.stage.sinks import Edge, RawPoses, ros_reader
from improv_core.stage.sinks.ros_reader import Reader

LIMIT = 60.0
ANNA = RobotSense("anna", "bump")
EDGE = '{"type": "edge", "robot": "anna", "sense": "bump", "value": false, "at": 1.0}'


@contextmanager
def reading(
    monkeypatch: pytest.MonkeyPatch, script: str
) -> Iterator[tuple[Reader, queue.SimpleQueue[Edge | RawPoses]]]:
    """A reader whose process runs a script, and what it hands on."""
    heard: queue.SimpleQueue[Edge | RawPoses] = queue.SimpleQueue()
    processes: list[subprocess.Popen[bytes]] = []

    def start(node: str) -> subprocess.Popen[bytes]:
        pipe = subprocess.PIPE
        processes.append(subprocess.Popen([sys.executable, "-c", script], stdin=pipe, stdout=pipe))
        return processes[-1]

    monkeypatch.setattr(ros_reader, "_start", start)
    reader = Reader("node", heard.put, time.monotonic)
    reader.read({ANNA: Topic("/anna/bump", "std_msgs/Bool")}, {})
    try:
        yield reader, heard
    finally:
        reader.close()
        assert all(each.returncode is not None for each in processes), "no process is left"


@pytest.mark.parametrize("line", ["[WARN] [reader]: a line of some library", '{"type": "edge"}', "[]"])
def test_what_can_not_be_read_leaves_no_sense_as_it_was(monkeypatch: pytest.MonkeyPatch, line: str) -> None:
    with reading(monkeypatch, f"print({EDGE!r}, flush=True); print({line!r}, flush=True); input()") as (reader, heard):
        assert heard.get(timeout=LIMIT) == Edge(ANNA, False, 1.0)
        silent = heard.get(timeout=LIMIT)
        assert isinstance(silent, Edge)
        assert (silent.what, silent.value) == (ANNA, None)
        assert reader.is_silent(ANNA)


def test_a_process_that_does_not_end_is_killed(monkeypatch: pytest.MonkeyPatch) -> None:
    script = f"import time; print({EDGE!r}, flush=True); time.sleep({LIMIT})"
    with reading(monkeypatch, script) as (_, heard):
        heard.get(timeout=LIMIT)
