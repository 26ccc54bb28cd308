"""ROS 2 for benchmarks: subscribers, publishers without Improv, and the times of commands."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from struct import Struct
from typing import Any, NamedTuple

from improv_core.safety.pending_zeros import LINGER

HERE = Path(__file__).parent
PYTHON = os.environ.get("IMPROV_ROS_PYTHON") or str(HERE.parents[1] / ".cache" / "ros" / "bin" / "python")
ENV = {
    **os.environ,
    "IMPROV_ROS_PYTHON": PYTHON,
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    "ROS_DOMAIN_ID": os.environ.get("ROS_DOMAIN_ID", "101"),  # no robot listens there in our tests
}
SIMULATED = HERE.parent / "ros" / "base.py"
RATE = 20
"""Commands a second to each robot."""
LIMIT = 60.0
"""Seconds to wait for anything, on a busy machine."""
_RECORD = Struct("<II7d")
"""Like the record of ros_listener.py, which only ROS's interpreter can import."""


@dataclass(frozen=True, slots=True)
class Heard:
    """A Twist: its publisher's number for it, from 1 on, and the times at which it was published, received and heard,
    in seconds of the monotonic clock. A listener that drains hears nothing."""

    number: int
    published: float
    received: float
    heard: float
    x: float
    y: float
    z: float
    yaw: float

    @property
    def velocity(self) -> tuple[float, float, float, float]:
        return self.x, self.y, self.z, self.yaw

    @property
    def still(self) -> bool:
        return not any(self.velocity)


class Due(NamedTuple):
    """A command for a topic: its time in seconds from beat 0, and whether it has another velocity."""

    at: float
    changes: bool


class Listener:
    """A subscriber to topics in its own process, started `by` a command, such as one that enters another network; use
    as a context manager, and `end` it to get its messages."""

    def __init__(self, way: str, topics: Sequence[str], by: Sequence[str] = (), env: Mapping[str, str] = ENV) -> None:
        self._topics = topics
        pipe = subprocess.PIPE
        command = [*by, PYTHON, str(HERE / "ros_listener.py"), way, *topics]
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, env=env)
        assert self._process.stdout
        self.versions: dict[str, str] = json.loads(self._process.stdout.readline())

    def __enter__(self) -> Listener:
        return self

    def __exit__(self, *failure: object) -> None:
        self._process.kill()
        self._process.communicate()

    def end(self) -> dict[str, list[Heard]]:
        """Return the messages of each topic, in order."""
        data, _ = self._process.communicate(timeout=LIMIT)
        if self._process.returncode:
            raise RuntimeError("the listener has failed")
        found: dict[str, list[Heard]] = {topic: [] for topic in self._topics}
        for place, *values in _RECORD.iter_unpack(data):
            found[self._topics[place]].append(Heard(*values))
        return found


@dataclass(frozen=True)
class Lateness:
    """Milliseconds by which each command was published and received after its due time; `changes` are those that were
    received with another velocity. `longest` is the longest time between two commands to one robot, in ms."""

    published: list[float]
    received: list[float]
    changes: list[float]
    longest: float
    missing: int

    def __add__(self, other: Lateness) -> Lateness:
        return Lateness(
            self.published + other.published,
            self.received + other.received,
            self.changes + other.changes,
            max(self.longest, other.longest),
            self.missing + other.missing,
        )


NOTHING = Lateness([], [], [], 0.0, 0)


def lateness(heard: Mapping[str, Sequence[Heard]], zero: float, due: Mapping[str, Sequence[Due]]) -> Lateness:
    """Compare the messages published from `zero` on with the commands that the topics should get.

    If some are missing, they are unknown, unless none of them was a change. Raises RuntimeError if a topic got more.
    """
    found = NOTHING
    for topic, commands in due.items():
        end = commands[-1].at + LINGER - 0.05  # then come zeros for robots that may have missed these
        messages = [each for each in heard[topic] if -0.01 < each.published - zero < end]
        missing = len(commands) - len(messages)
        if missing < 0:
            raise RuntimeError(f"{topic} got {len(messages)} commands instead of {len(commands)}")
        new = [two for one, two in pairwise([None, *messages]) if two and not (one and one.velocity == two.velocity)]
        expected = [each.at for each in commands if each.changes]
        pairs = [] if missing else list(zip(commands, messages, strict=True))
        found += Lateness(
            [(each.published - zero - command.at) * 1000 for command, each in pairs],
            [(each.received - zero - command.at) * 1000 for command, each in pairs],
            [(each.received - zero - at) * 1000 for at, each in zip(expected, new, strict=False)]
            if len(expected) == len(new)
            else [],
            max((two.received - one.received for one, two in pairwise(messages)), default=0.0) * 1000,
            missing,
        )
    return found


def base(
    name: str, start: Sequence[float], options: Sequence[str], by: Sequence[str] = (), env: Mapping[str, str] = ENV
) -> subprocess.Popen[str]:
    """Start a simulated base at a pose, and wait until it listens. It prints its true pose once its input ends."""
    command = [*by, PYTHON, str(SIMULATED), name, "--start", *map(str, start), *options]
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, env=env, stdin=pipe, stdout=pipe, stderr=subprocess.DEVNULL, text=True)
    assert process.stdout
    process.stdout.readline()
    return process


def end_of(base: subprocess.Popen[str]) -> list[float]:
    """End a simulated base, and return its true pose."""
    return [*map(float, base.communicate(timeout=LIMIT)[0].split())]


def beat_0(transport: Mapping[str, Any]) -> float:
    """Return the time of beat 0, by the monotonic clock."""
    return float(transport["monotonic"] - transport["beat"] * 60 / transport["tempo"])


class Plain:
    """A plain script that publishes 20 times a second, for this many seconds once all topics have listeners."""

    def __init__(self, seconds: int, topics: Sequence[str]) -> None:
        self._topics = topics
        self._seconds = seconds
        command = [PYTHON, str(HERE / "ros_publisher.py"), str(seconds), *topics]
        told = subprocess.run(command, stdout=subprocess.PIPE, env=ENV, check=True, timeout=seconds + LIMIT)
        self.zero = float(told.stdout)
        """Time at which it began."""

    @property
    def due(self) -> dict[str, list[Due]]:
        """Commands that each topic should get."""
        commands = [Due(count / RATE, count % RATE == 0) for count in range(self._seconds * RATE)]
        return dict.fromkeys(self._topics, commands)
