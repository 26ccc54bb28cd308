"""Drives the ROS sink alone, in ROS's interpreter: a line of input is [method, arguments, named arguments]."""

from __future__ import annotations

import json
import queue
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).parents[2]))  # as the stage does: last, and not installed

from improv_core.score import senses
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.profiles import TURTLESIM
from improv_core.score.score import Part, Score
from improv_core.stage.sinks import RawPoses
from improv_core.stage.sinks.ros import Ros

LIMIT = 60.0
"""Seconds to wait for anything, as in conftest.py."""


def answer(value: Any) -> None:
    print(json.dumps(value), flush=True)


def prepare(topics: dict[str, str], restart: bool = True, profile: Any = (), **part: Any) -> None:
    """Robots on these topics; what is given of a part and its profile is alike for all."""
    made = replace(TURTLESIM, **dict(profile))
    part["senses"] = senses.from_json(part.get("senses", {}))
    parts = {robot: Part(robot, (), made, Pose(), topic, **part) for robot, topic in topics.items()}
    sink.prepare(Score(Fraction(60), parts), restart)


def send(robot: str, x: float, y: float, z: float, yaw: float) -> None:
    sink.send(robot, Twist(x, y, z, yaw), 0.0)


def refuse(robot: str, x: float) -> str:
    """What is said of a velocity that can't be sent."""
    try:
        sink.send(robot, Twist(x), 0.0)
    except ValueError as error:
        return str(error)
    return "sent"


def until(fits: Callable[[], Any]) -> None:
    """Look as often as the player does."""
    end = time.monotonic() + LIMIT
    while not fits():
        if time.monotonic() > end:
            raise TimeoutError(f"missing: {sink.missing()}, warnings: {sink.warnings()}")
        time.sleep(0.01)


def wait() -> None:
    """Until the player would begin."""
    until(lambda: not (sink.resetting() or sink.missing()))


def wait_for_reset() -> float:
    """The seconds for which the player would wait."""
    began = time.monotonic()
    until(lambda: not sink.resetting())
    return time.monotonic() - began


def find(lines: str, robot: str, part: str) -> str:
    """The line about a robot among these ("missing" or "warnings"), once it has this part in it."""
    until(lambda: part in methods[lines]().get(robot, ""))
    return str(methods[lines]()[robot])


def until_missing() -> None:
    until(sink.missing)


def until_no_warnings() -> None:
    until(lambda: not sink.warnings())


def until_offered(topic: str, *types: str) -> None:
    """Until everybody is heard, and these are the types of all publishers there."""
    until(lambda: not sink.missing() and offered(topic) == types)


def offered(topic: str) -> tuple[str, ...]:
    return tuple(sorted(info.topic_type for info in sink._node.get_publishers_info_by_topic(topic)))


def edge() -> Any:
    """The next edge: robot, sense, value; and how long ago it came."""
    found = edges.get(timeout=LIMIT)
    return [*found.what, found.value], time.monotonic() - found.at


def no_more_edges() -> bool:
    return edges.empty()


def pose() -> Any:
    """The next pose: robot, source, x, y, heading; and how long ago it came."""
    while not isinstance(found := edges.get(timeout=LIMIT), RawPoses):
        pass
    robot, source, where, at, _ = found.poses[0]
    return [robot, source, where.x, where.y, round(where.heading, 6)], time.monotonic() - at


def end(*_: object) -> None:
    sink.send("turtle1", STILL, 0.0)
    sink.close()
    sys.exit(0)


signal.signal(signal.SIGTERM, end)
edges: queue.SimpleQueue[Any] = queue.SimpleQueue()
sink = Ros(None, "standby" in sys.argv[1:], edges.put, lambda request: None)
answer(sink.description)
methods: dict[str, Callable[..., Any]] = {
    "prepare": prepare,
    "missing": sink.missing,
    "warnings": sink.warnings,
    "resetting": sink.resetting,
    "send": send,
    "refuse": refuse,
    "wait": wait,
    "wait_for_reset": wait_for_reset,
    "find": find,
    "edge": edge,
    "pose": pose,
    "no_more_edges": no_more_edges,
    "until_missing": until_missing,
    "until_no_warnings": until_no_warnings,
    "offered": offered,
    "until_offered": until_offered,
}
for line in sys.stdin:
    method, arguments, named = json.loads(line)
    answer(methods[method](*arguments, **named))
sink.close()
