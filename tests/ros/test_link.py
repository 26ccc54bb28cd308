"""A stage on another machine, through a real ssh server and with a real robot: for its parent, it is like any other."""

from __future__ import annotations

import asyncio
import os
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from improv_core.playback.stage_process import Stage
from improv_core.playback.stops import Stops
from improv_core.program.analysis import analyze
from improv_core.program.compiler import score_of
from improv_core.score.score_json import to_json
from improv_core.stage.messages import ToStage
from tests.processes import descendants, wait_until_gone
from tests.remote.sshd import Host, a_host
from tests.ros.conftest import LIMIT, Listen

pytestmark = pytest.mark.slow("a real ssh server, and a stage of ROS 2 that finds its robots")


@pytest.fixture
def host(tmp_path: Path, ros_env: Mapping[str, str]) -> Iterator[Host]:
    """The machine of the robots. What a person has set here does not hold there."""
    there = {name: value for name, value in ros_env.items() if os.environ.get(name) != value}
    with a_host(tmp_path, there) as host:
        yield host


class Parent:
    """A parent, on an event loop of its own."""

    def __init__(self, host: Host, command: list[str]) -> None:
        self.heard: list[Any] = []
        self._changed = threading.Condition()
        self._loop = asyncio.new_event_loop()
        threading.Thread(target=self._loop.run_forever, daemon=True).start()
        self.stage: Stage = self._do(Stage.start(command, host.env, self._hear, Stops()))

    def send(self, message: ToStage) -> None:
        self._loop.call_soon_threadsafe(self.stage.send, message)

    def load(self, program: str, **fields: Any) -> None:
        score = to_json(score_of(analyze(program)))
        load: Any = {"type": "load", "generation": 1, "score": score, "when": "restart", "backend": "ros"}
        loads: Any = {**load, **fields}
        self.send(loads)

    def wait(self, fits: Callable[[Any], bool]) -> Any:
        """The first message that fits."""
        with self._changed:
            assert self._changed.wait_for(lambda: any(map(fits, self.heard)), LIMIT), self.heard[-5:]
            return next(filter(fits, self.heard))

    def close(self) -> None:
        self._do(self.stage.close())
        self._loop.call_soon_threadsafe(self._loop.stop)

    def _do(self, work: Any) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(LIMIT)

    def _hear(self, stage: Stage, message: Any, stops: int) -> None:
        with self._changed:
            self.heard.append(message)
            self._changed.notify_all()


@contextmanager
def a_parent(host: Host, *options: str, **named: Any) -> Iterator[Parent]:
    parent = Parent(host, host.command(*options, **named))
    try:
        yield parent
    finally:
        parent.close()


def says(kind: str, **fields: Any) -> Callable[[Any], bool]:
    return lambda message: message["type"] == kind and fields.items() <= message.items()


def test_a_dance_is_played_where_the_robots_are_and_stops_with_its_parent(host: Host, listen: Listen) -> None:
    turtle = listen("/turtle1/cmd_vel")
    before = descendants(os.getpid())
    with a_parent(host, "--report-sent") as parent:
        assert parent.stage.ready["real"]
        (version,) = host.versions()
        parent.load("turtle1 $ repeat forward")
        turtle.wait(lambda heard: heard["x"] == 2)
        playing = parent.wait(says("transport", state="playing"))
        assert time.monotonic() - 20 < playing["monotonic"] < time.monotonic()
        assert time.time() - 20 < playing["wall"] < time.time()
        link = parent.wait(says("link"))
        assert link["host"] == "robot"
        assert abs(link["offset"]) < max(link["error"], 0.002)  # both clocks are the same
        parent.send({"type": "pause"})
        turtle.wait(lambda heard: heard["x"] == 0)
        parent.wait(says("transport", state="paused"))
        parent.send({"type": "resume"})
        turtle.wait(lambda heard: heard["x"] == 2)
        started = {pid: fd for pid, fd in descendants(os.getpid()).items() if pid not in before}
        assert not any(message["type"] in ("error", "gone") for message in parent.heard)
    turtle.wait(lambda heard: heard["x"] == 0)
    wait_until_gone(started, LIMIT)
    assert host.versions() == [version]
    assert [path.name for path in host.home.iterdir() if path.name != ".ros"] == []
