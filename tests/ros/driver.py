"""Drive the ROS sink alone, in ROS's interpreter: a line of input is [method, arguments, named arguments]."""

from __future__ import annotations

import json
import math
import queue
import signal
import sys
import time
import traceback
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).parents[2]))  # as the stage does: last, and not installed

import own_output  # noqa: F401, before any library may print
from rclpy.utilities import get_default_context

from improv_core.ipc.arrivals import End
from improv_core.outputs.ros.output import RosSink
from improv_core.outputs.ros.standby.client import start_standby
from improv_core.protocol.output import Alarm, BaseCommand, Edge, RawPoses
from improv_core.score.algebra import hold, stand
from improv_core.score.body import Body, BodyPart, Controller, Drive, Joint
from improv_core.score.by_part import by_part
from improv_core.score.motion import STILL, Pose, Twist
from improv_core.score.movement import Velocity
from improv_core.score.peer_clock import Anchor
from improv_core.score.profiles import PUPPET, TURTLESIM
from improv_core.score.score import Deadman, OutsideClock, Part, Safety, Score
from improv_core.score.senses import BuiltIn, Topic

LIMIT = 60.0
"""Seconds to wait for an event, as in conftest.py."""


def answer(value: Any) -> None:
    print(json.dumps(value), flush=True)


def prepare(
    topics: dict[str, str],
    restart: bool = True,
    profile: Any = (),
    stop: str | None = None,
    deadman: tuple[str, int] | None = None,
    puppets: Sequence[str] = (),
    stops: bool = False,
    follows_time: bool = False,
    **part: Any,
) -> None:
    """Prepare robots on these topics. All have the same part and profile, but some may be puppets. They perform a part,
    or only have to stop."""
    made = replace(TURTLESIM, **dict(profile))
    part["senses"] = {
        name: (Topic if "topic" in each else BuiltIn)(**each) for name, each in part.get("senses", {}).items()
    }
    parts = {
        robot: Part(robot, () if stops else (stand(1),), PUPPET if robot in puppets else made, Pose(), topic, **part)
        for robot, topic in topics.items()
    }
    safety = Safety(stop=stop, deadman=deadman and Deadman(*deadman))
    clock = OutsideClock("ros") if follows_time else None
    sink.prepare(Score(Fraction(60), parts, safety=safety, clock=clock), restart)


def prepare_body(controller: dict[str, Any], **joint: Any) -> None:
    """Prepare a robot ada that turns its head by a joint, whose start it has to move to."""
    head = BodyPart("head", [Drive("yaw", "yaw", 1.0)])
    body = Body([head], (), [Joint("yaw", **joint)], [Controller(**controller)], "joint_states", "move")
    scene, profile = by_part(hold(Velocity(0, 0, 0, 1), 1), "head"), replace(TURTLESIM, body=body)
    part = Part("ada", (scene,), profile, Pose(), "/ada/cmd_vel", namespace="/ada")
    sink.prepare(Score(Fraction(60), {"ada": part}), True)


def stop_on_the_way_home() -> None:
    """Move ada's joint toward its start until it moves, then stop ada."""

    def moves() -> bool:
        if missing := sink.missing():
            sink.ask(missing)
        sink.resetting([] if missing else ["ada"])
        return any(controller.moves for controller in sink._controllers._robots["ada"])

    until(moves)
    publish("ada", STILL)


def publish(robot: str, twist: Twist) -> None:
    sink.ready([BaseCommand(robot, twist, 0.0)])()


def send(robot: str, x: float, y: float, z: float, yaw: float) -> None:
    publish(robot, Twist(x, y, z, yaw))


def stop_without(lost: str) -> list[str]:
    """Send all robots a zero after one has lost its publishers. Return the topics that the standby would still stop."""
    for publisher in sink._robots[lost].topic._publishers.values():
        publisher.destroy()
    try:
        sink.ready([BaseCommand(robot, STILL, 0.0) for robot in sink._current])()
    except Exception:  # rclpy says that the publisher is gone
        return [*sink._standby.moving]
    raise AssertionError("nothing says that a zero could not be sent")


def refuse(robot: str, x: float) -> str:
    """Return the error about a velocity that can't be sent."""
    try:
        publish(robot, Twist(x))
    except ValueError as error:
        return str(error)
    return "sent"


def until(fits: Callable[[], Any], *, asks: bool = False) -> None:
    """Look as often as the player, which asks listeners only before robots move."""
    end = time.monotonic() + LIMIT
    while not fits():
        if time.monotonic() > end:
            raise TimeoutError(f"missing: {sink.missing()}, warnings: {sink.warnings()}")
        sink.advance(0.0)
        if asks:
            sink.ask(sink._current)
        time.sleep(0.01)


def wait(listeners: int = 0) -> None:
    """Wait until the player would begin, and this many listeners have been found on each topic and hear it."""

    def ready() -> bool:
        found = all(topic.count_listeners() >= listeners for topic in sink._topics.values())
        return not (sink.resetting() or sink.missing()) and found

    until(ready, asks=True)


def wait_for_reset() -> None:
    """Wait as long as the player would."""
    until(lambda: not sink.resetting())


def find(lines: str, robot: str, part: str) -> str:
    """Wait for a line about a robot in these ("missing" or "warnings") that contains a text, and return it."""
    found = ""

    def fits() -> bool:
        nonlocal found
        found = getattr(sink, lines)().get(robot, "")
        return part in found

    until(fits, asks=lines == "missing")
    return found


def battery(robot: str) -> float:
    """Wait for a robot's battery level, and return it."""
    until(lambda: robot in sink.noticed().batteries)
    return sink.noticed().batteries[robot]


def node() -> str:
    return str(sink._node.get_fully_qualified_name())


def retry() -> None:
    sink.pending_zeros.retry(time.monotonic())


def until_ready() -> None:
    """Wait until a standby could stop all robots."""

    def ready() -> bool:
        return sink._standby.works and sink._standby.is_ready(set(sink._topics))

    until(ready)


def until_missing() -> None:
    until(sink.missing)


def until_no_zero_pends() -> None:
    """Wait until no zero is pending."""

    def none_pending() -> bool:
        retry()
        return sink.pending_zeros.due == math.inf

    until(none_pending)


def until_no_warnings() -> None:
    until(lambda: not sink.warnings())


def until_offered(topic: str, *types: str) -> None:
    """Wait until all listeners are served, one of each type, and all publishers there have these types."""

    def are_offered() -> bool:
        # A publisher of a type that nobody wants lingers: the other type's listener may not have been found yet.
        is_served = not sink.missing() and sink._topics[topic].count_listeners() >= len(types)
        return is_served and offered(topic) == types

    until(are_offered, asks=True)


def offered(topic: str) -> tuple[str, ...]:
    return tuple(sorted(info.topic_type for info in sink._node.get_publishers_info_by_topic(topic)))


def _next(kind: Any) -> Any:
    """Wait for the next message of this kind, and return it. Look around meanwhile, as the player does."""
    end = time.monotonic() + LIMIT
    while time.monotonic() < end:
        sink.advance(0.0)
        with suppress(queue.Empty):
            if isinstance(found := heard.get(timeout=0.05), kind):
                return found
    raise TimeoutError(f"no {kind} was heard; missing: {sink.missing()}, warnings: {sink.warnings()}")


def edge() -> Any:
    """Wait for the next edge, and return its subject and its value."""
    found = _next(Edge)
    what = found.what
    return [*([what] if isinstance(what, str) else what), found.value]


def alarm() -> str:
    """Wait for the next line that stops all robots, and return it."""
    found = _next(Alarm | End)
    return str(found.message if isinstance(found, Alarm) else found.problem)


def pose() -> Any:
    """Wait for the next pose: robot, source, x, y, heading; and its age in seconds."""
    found = _next(RawPoses)
    robot, source, where, at, *_ = found.poses[0]
    return [robot, source, where.x, where.y, round(where.heading, 6)], time.monotonic() - at


def rate() -> float:
    """Wait for the rate of a simulation's time, and return it."""
    return float(_next(Anchor).rate)


def end(*_: object) -> None:
    publish("turtle1", STILL)
    sink.close()
    sys.exit(0)


def leave() -> None:
    """Leave ROS."""
    global is_there
    if is_there:
        is_there = False
        sink.close()
        get_default_context(shutting_down=True)  # the next sink gets another
        while not heard.empty():
            heard.get()


def renew() -> str:
    """Replace this sink by another one. Return its description."""
    global sink, is_there
    leave()
    sink, is_there = make(), True
    return sink.description


def make() -> RosSink:
    arguments = [each for each in sys.argv[1:] if each != "standby"]
    standby = start_standby(None, (), "standby" in sys.argv[1:])
    return RosSink(standby, heard.put, lambda request: None, arguments=arguments)


signal.signal(signal.SIGTERM, end)
heard: queue.SimpleQueue[Any] = queue.SimpleQueue()
sink, is_there = make(), True
answer([True, sink.description])
own = globals()
for line in sys.stdin:
    method, arguments, named = json.loads(line)
    try:
        call = own.get(method) or getattr(sink, method)
        answer([True, call(*arguments, **named)])
    except Exception:  # the next test can continue with another sink
        answer([False, traceback.format_exc()])
leave()
