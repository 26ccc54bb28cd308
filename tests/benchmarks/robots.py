"""ROS 2 for measuring: somebody who listens, somebody who publishes without us, and when a command came."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from pathlib import Path
from statistics import linear_regression, median
from struct import Struct
from time import monotonic

HERE = Path(__file__).parent
PYTHON = os.environ.get("IMPROV_ROS_PYTHON") or str(HERE.parents[1] / ".cache" / "ros" / "bin" / "python")
ENV = {
    **os.environ,
    "IMPROV_ROS_PYTHON": PYTHON,
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    "ROS_DOMAIN_ID": "101",  # nobody listens there in our tests
}
RATE = 20
"""Commands a second to each robot."""
LIMIT = 60.0
"""Seconds to wait for anything, on a busy machine."""
_RECORD = Struct("<II7d")
"""As in ros_listener.py, which only ROS's interpreter can import."""


@dataclass(frozen=True, slots=True)
class Heard:
    """A Twist: its publisher's number for it, from 1 on, and when it was published, received and heard, in seconds of
    the monotonic clock. A listener that drains hears nothing."""

    number: int
    published: float
    received: float
    heard: float
    x: float
    y: float
    z: float
    yaw: float

    @property
    def still(self) -> bool:
        return not (self.x or self.y or self.z or self.yaw)


class Listener:
    """A subscriber to topics in a process of its own; use as a context manager, and `end` it to know what it heard."""

    def __init__(self, way: str, topics: Sequence[str]) -> None:
        self._topics = topics
        pipe = subprocess.PIPE
        command = [PYTHON, str(HERE / "ros_listener.py"), way, *topics]
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, env=ENV)
        assert self._process.stdout
        self.versions: dict[str, str] = json.loads(self._process.stdout.readline())

    def __enter__(self) -> Listener:
        return self

    def __exit__(self, *failure: object) -> None:
        self._process.kill()
        self._process.communicate()

    @property
    def pid(self) -> int:
        return self._process.pid

    def end(self) -> dict[str, list[Heard]]:
        """What each topic brought, in order."""
        data, _ = self._process.communicate(timeout=LIMIT)
        if self._process.returncode:
            raise RuntimeError("the listener has failed")
        found: dict[str, list[Heard]] = {topic: [] for topic in self._topics}
        for place, *values in _RECORD.iter_unpack(data):
            found[self._topics[place]].append(Heard(*values))
        return found


@dataclass(frozen=True)
class Lateness:
    """When commands ought to have been sent (s), and how much later each was published and received (ms)."""

    due: Sequence[float]
    published: Sequence[float]
    received: Sequence[float]
    missing: int

    @cached_property
    def drift(self) -> float:
        """By how much they get later, in ms a minute; seconds count alike, so that one bad moment is not all."""
        seconds = groupby(sorted(zip(self.due, self.published, strict=True)), lambda each: int(each[0]))
        middles = [(second, median(late for _, late in each)) for second, each in seconds]
        return linear_regression(*zip(*middles, strict=True)).slope * 60 if len(middles) > 1 else 0.0


def lateness(heard: dict[str, list[Heard]], zero: float, due: Sequence[float]) -> Lateness:
    """Of robots that were to get commands at these times after `zero`, which are the first ones of their publishers."""
    each = [(due[one.number - 1], one) for messages in heard.values() for one in messages]
    return Lateness(
        [at for at, _ in each],
        [(one.published - zero - at) * 1000 for at, one in each],
        [(one.received - zero - at) * 1000 for at, one in each],
        len(due) * len(heard) - len(each),
    )


def start_anew(topic: str) -> float:
    """Start a plain script that publishes, and wait until it ends; when it was started."""
    begin = monotonic()
    subprocess.run([PYTHON, str(HERE / "ros_publisher.py"), "anew", topic], env=ENV, check=True, timeout=LIMIT)
    return begin


class Steady:
    """A plain script that publishes 20 times a second, for so many seconds once all topics are listened to."""

    def __init__(self, seconds: float, topics: Sequence[str]) -> None:
        command = [PYTHON, str(HERE / "ros_publisher.py"), "steady", str(seconds), *topics]
        self.due = [count / RATE for count in range(round(seconds * RATE))]
        self._process = subprocess.Popen(command, stdout=subprocess.PIPE, env=ENV)

    @property
    def runs(self) -> bool:
        return self._process.poll() is None

    def zero(self) -> float:
        """When it began, once it has ended."""
        told, _ = self._process.communicate(timeout=LIMIT)
        return float(told)
