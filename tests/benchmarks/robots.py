"""ROS 2 for benchmarks: subscribers, and simulated bases."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from struct import Struct

HERE = Path(__file__).parent
PYTHON = os.environ.get("IMPROV_ROS_PYTHON") or str(HERE.parents[1] / ".cache" / "ros" / "bin" / "python")
ENV = {
    **os.environ,
    "IMPROV_ROS_PYTHON": PYTHON,
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    "ROS_DOMAIN_ID": os.environ.get("ROS_DOMAIN_ID", "101"),  # no robot listens there in our tests
}
SIMULATED = HERE.parent / "ros" / "base.py"
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


class Listener:
    """A subscriber to topics in its own process, started `by` a command, such as one that enters another network; use
    as a context manager, and `end` it to get its messages."""

    def __init__(self, way: str, topics: Sequence[str], by: Sequence[str] = (), env: Mapping[str, str] = ENV) -> None:
        self._topics = topics
        pipe = subprocess.PIPE
        command = [*by, PYTHON, str(HERE / "ros_listener.py"), way, *topics]
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, env=env)
        assert self._process.stdout
        self._process.stdout.readline()

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
