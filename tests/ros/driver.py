"""Drives the ROS sink alone, in ROS's interpreter: each line of input is [method, arguments...], each is answered."""

from __future__ import annotations

import json
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).parents[2]))  # as the stage does: last, and not installed

from improv_core.motion import STILL, Pose, Twist
from improv_core.movement import series
from improv_core.profiles import TURTLESIM
from improv_core.score import Part
from improv_core.stage.sinks.ros import Ros


def answer(value: Any) -> None:
    print(json.dumps(value), flush=True)


def prepare(topics: dict[str, str], restart: bool = True) -> None:
    parts = {robot: Part(robot, series([]), TURTLESIM, Pose(), topic) for robot, topic in topics.items()}
    sink.prepare(parts, restart)


def send(robot: str, x: float, y: float, z: float, yaw: float) -> None:
    sink.send(robot, Twist(x, y, z, yaw), 0.0)


def wait() -> None:
    """Until everybody is heard, looking as often as the player does; the test has the limit."""
    while sink.missing():
        time.sleep(0.01)


def end(*_: object) -> None:
    sink.send("turtle1", STILL, 0.0)
    sink.close()
    sys.exit(0)


signal.signal(signal.SIGTERM, end)
sink = Ros(None)
answer(sink.description)
methods: dict[str, Callable[..., Any]] = {"prepare": prepare, "missing": sink.missing, "send": send, "wait": wait}
for line in sys.stdin:
    method, *arguments = json.loads(line)
    answer(methods[method](*arguments))
sink.close()
