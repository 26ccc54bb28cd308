"""A ROS 2 of the test's own: its interpreter, an environment nobody else shares, and real subscribers."""

from __future__ import annotations

import json
import math
import os
import queue
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from improv_core.score.senses import Message
from tests.needs import lacking

LIMIT = 60.0
"""Seconds to wait for anything: discovery alone may take several on a busy machine."""

DRIVER = Path(__file__).parent / "driver.py"
LISTENER = Path(__file__).parent / "listener.py"
SENSOR = Path(__file__).parent / "sensor.py"
OWN = Path(__file__).parents[2] / ".cache" / "ros" / "bin" / "python"


class Listener:
    """A subscriber in a process of its own, and what it has heard: dicts of topic, at, x, y, z, yaw."""

    def __init__(self, python: str, env: Mapping[str, str], *arguments: str) -> None:
        self.heard: list[dict[str, Any]] = []
        self._publishers = 0
        self._changed = threading.Condition()
        self._inbox: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._process = subprocess.Popen(
            [python, LISTENER, *arguments], env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        threading.Thread(target=self._read, daemon=True).start()
        while "ready" not in self._inbox.get(timeout=LIMIT):
            pass  # a message may come first

    @property
    def pid(self) -> int:
        return self._process.pid

    def wait(self, fits: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """The next message that fits, which may be one heard before this call."""
        end = time.monotonic() + LIMIT
        while True:
            try:
                message = self._inbox.get(timeout=max(end - time.monotonic(), 0))
            except queue.Empty:
                raise AssertionError(f"not heard within {LIMIT} s; heard {self.heard[-5:]}") from None
            self.heard.append(message)
            if fits(message):
                return message

    def wait_for_publishers(self, count: int) -> None:
        """Until as many are known to publish on one of its topics."""
        with self._changed:
            assert self._changed.wait_for(lambda: self._publishers >= count, LIMIT)

    def kill(self) -> None:
        """It vanishes without a word."""
        self._process.kill()

    def close(self) -> None:
        assert self._process.stdin
        self._process.stdin.close()
        try:
            self._process.wait(timeout=LIMIT)
        except subprocess.TimeoutExpired:
            self._process.kill()
            raise

    def _read(self) -> None:
        assert self._process.stdout
        with self._process.stdout as lines:
            for line in lines:
                message = json.loads(line)
                if "publishers" in message:
                    with self._changed:
                        self._publishers = message["publishers"]
                        self._changed.notify_all()
                else:
                    self._inbox.put(message)


class Sink:
    """The sink in a process of its own: `sink("missing")` calls the method and returns its answer."""

    def __init__(self, python: str, env: Mapping[str, str], *arguments: str) -> None:
        self.process = subprocess.Popen(
            [python, DRIVER, *arguments], env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.description = self._answer()

    def __call__(self, method: str, *arguments: Any, **named: Any) -> Any:
        assert self.process.stdin
        self.process.stdin.write(json.dumps([method, arguments, named]) + "\n")
        self.process.stdin.flush()
        return self._answer()

    def close(self) -> None:
        self.process.communicate(timeout=LIMIT)

    def _answer(self) -> Any:
        assert self.process.stdout
        return json.loads(self.process.stdout.readline())


Listen = Callable[..., Listener]


@pytest.fixture(scope="session")
def ros_python() -> str:
    """A Python that imports rclpy."""
    python = os.environ.get("IMPROV_ROS_PYTHON") or (str(OWN) if OWN.exists() else "")
    if not python:
        lacking("no ROS 2: run `sh tests/ros/fetch.sh`, or set IMPROV_ROS_PYTHON to a Python with rclpy")
    return python


@pytest.fixture(scope="session")
def ros_env(ros_python: str) -> dict[str, str]:
    """An environment in which our server finds ROS 2, on this machine only, in a domain of this run's own."""
    return {
        **os.environ,
        "IMPROV_ROS_PYTHON": ros_python,
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        # The domains that are safe beside Linux's ephemeral ports end at 101.
        "ROS_DOMAIN_ID": str(1 + os.getpid() % 100),
    }


@pytest.fixture(scope="module")
def turtle(ros_python: str, ros_env: dict[str, str]) -> Iterator[Listener]:
    """One listener for all tests of a module, as turtle1: somebody else moves it in each."""
    turtle = Listener(ros_python, ros_env, "/turtle1/cmd_vel")
    yield turtle
    turtle.close()


@pytest.fixture
def listen(ros_python: str, ros_env: dict[str, str]) -> Iterator[Listen]:
    """Starts others in ROS: `listen("/r/cmd_vel", "--stamped")`; listener.py says what they can do."""
    listeners: list[Listener] = []

    def start(*arguments: str) -> Listener:
        listeners.append(Listener(ros_python, ros_env, *arguments))
        return listeners[-1]

    yield start
    for listener in listeners:
        listener.close()


@pytest.fixture
def start(ros_python: str, ros_env: dict[str, str]) -> Iterator[Callable[..., Sink]]:
    """Starts sinks, with variables that differ from the environment of all tests."""
    sinks: list[Sink] = []

    def begin(*arguments: str, **variables: str) -> Sink:
        sinks.append(Sink(ros_python, {**ros_env, **variables}, *arguments))
        return sinks[-1]

    yield begin
    for sink in sinks:
        sink.close()


@pytest.fixture
def sink(start: Callable[..., Sink]) -> Sink:
    return start()


SCAN = {"angle_min": -math.pi, "angle_max": math.pi, "angle_increment": math.pi / 180, "range_min": 0.1}
SCAN |= {"range_max": 10.0}


def scan(ahead: float) -> dict[str, Any]:
    """A scan in which something is straight ahead, and nothing else."""
    return {**SCAN, "ranges": [math.inf] * 175 + [ahead] * 10 + [math.inf] * 175}


class Sensor:
    """A publisher in a process of its own."""

    def __init__(self, process: subprocess.Popen[str]) -> None:
        self.process = process

    def __call__(self, fields: dict[str, Any] | None, **more: Any) -> None:
        print(json.dumps(fields and {**fields, **more}), file=self.process.stdin, flush=True)


Sense = Callable[..., Sensor]

SHORT_LEASE = Path(__file__).with_name("short_lease.xml")


@pytest.fixture
def sensor(script: Script) -> Sense:
    """Starts sensors. Others miss one that is killed after two seconds: its lease ends, which usually takes 20."""

    def start(topic: str, message: Message) -> Sensor:
        return Sensor(script(SENSOR, topic, message, FASTRTPS_DEFAULT_PROFILES_FILE=str(SHORT_LEASE)))

    return start


Script = Callable[..., "subprocess.Popen[str]"]


@pytest.fixture
def script(ros_python: str, ros_env: dict[str, str]) -> Iterator[Script]:
    """Starts scripts in ROS's interpreter. Each is ready when it prints a line, and ends when its input does."""
    started: list[subprocess.Popen[str]] = []

    def start(path: Path, *arguments: str, **variables: str) -> subprocess.Popen[str]:
        pipe, env = subprocess.PIPE, {**ros_env, **variables}
        process = subprocess.Popen([ros_python, path, *arguments], env=env, stdin=pipe, stdout=pipe, text=True)
        started.append(process)
        assert process.stdout
        process.stdout.readline()
        return process

    yield start
    for process in started:
        process.communicate(timeout=LIMIT)
