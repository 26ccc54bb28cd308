"""Reads robots' sensors from ROS topics and reports only changes to the stage, instead of up to 2,000 scans a second.

Of each robot's poses and joints, it reports the latest, at most twenty times a second.

It is a process of its own, because reading would make the stage's commands late. The stage starts it with its own
interpreter, as `python …/improv_core/stage reader`. Standard library only (rclpy imported lazily).
"""

from __future__ import annotations

import gc
import math
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import chain
from typing import NamedTuple

from improv_core.outputs.cdr import joints_in
from improv_core.outputs.ros.sensors.poses import PoseReader
from improv_core.outputs.ros.sensors.readings import battery
from improv_core.protocol.fields import to_pose_json
from improv_core.protocol.json_lines import Lines, own_output
from improv_core.protocol.output import Edge, RawPose
from improv_core.protocol.reader_messages import FromReader, MeasuredPose, ToReader
from improv_core.score.senses import RobotSense, Topic

NICENESS = 5
"""The process's niceness. If all processors are busy, commands come first, unless robots have to keep apart: then poses
are as urgent."""
PROMPT = "prompt"
"""The second argument, if poses are as urgent as commands; otherwise it is empty."""
LOOK = 0.05
"""The most seconds between two checks for silence and for messages of the stage."""


def main() -> int:
    """Read the senses that the stage requests on standard input, until that ends; edges go to standard output."""
    lines: Lines[ToReader] = Lines()
    tell: Callable[[FromReader], None] = own_output()
    node, haste, *arguments = sys.argv[1:]
    if haste != PROMPT:
        os.nice(NICENESS)
    from improv_core.outputs.ros.sensors.subscriptions import Subscriptions

    senses, poses = HeardSenses(time.monotonic()), PoseReader()

    def tell_edges(edges: Iterable[Edge]) -> None:
        for edge in edges:
            assert isinstance(edge.what, RobotSense)
            robot, sense = edge.what
            tell({"type": "edge", "robot": robot, "sense": sense, "value": edge.value, "at": edge.at})

    def hear(topic: Topic, value: bool | None) -> None:
        tell_edges(senses.take(topic, value, time.monotonic()))

    def tell_unread(topic: str, message: str) -> None:
        tell({"type": "unread", "topic": topic, "message": message})

    subscriptions = Subscriptions(node, arguments, hear, tell_unread)
    # As in the stage: collecting garbage among all imported modules would make edges late.
    gc.freeze()
    gc.set_threshold(50_000, 20, 100)
    period = LOOK
    while not lines.ended:
        for message in lines.read():
            asked = {RobotSense(each["robot"], each["sense"]): Topic(**each["source"]) for each in message["senses"]}
            tell_edges(senses.read(asked, time.monotonic()))
            subscriptions.keep(senses.topics)
            period = message["period"]
            subscriptions.poses.keep(message["odometry"])
            poses.bases = message["bases"]
            subscriptions.batteries.keep(message["batteries"])
            subscriptions.joint_states.keep(message["joint_states"])
        subscriptions.spin(min(period, LOOK))
        if found := poses.take(subscriptions.poses.take()):
            tell({"type": "poses", "poses": [*map(_pose, found)]})
        for robots, _, _, messages in subscriptions.batteries.take():
            if (share := battery(messages[-1][0])) is not None:
                tell({"type": "batteries", "batteries": dict.fromkeys(robots, share)})
        for robots, _, _, messages in subscriptions.joint_states.take():
            if positions := dict(chain.from_iterable(joints_in(message).items() for message, _ in messages)):
                for robot in robots:
                    tell({"type": "joints", "robot": robot, "positions": positions, "at": time.monotonic()})
        tell({"type": "alive"})
        tell_edges(senses.look(subscriptions.is_published, time.monotonic()))
    subscriptions.close()
    return 0


class HeardSenses:
    """Turns values from topics, their times (in seconds), and silence into edges. It never reads a clock."""

    def __init__(self, now: float) -> None:
        self._read: dict[Topic, dict[RobotSense, None]] = {}
        self._known: dict[Topic, _Known] = {}
        self._looked = now

    @property
    def topics(self) -> Iterable[Topic]:
        return self._read.keys()

    def read(self, sources: Mapping[RobotSense, Topic], now: float) -> Iterator[Edge]:
        """Read only these senses from now on. All others become silent."""
        old = {sense: topic for topic, senses in self._read.items() for sense in senses}
        before = {sense: self._value(topic) for sense, topic in old.items()}
        self._read = {}
        for sense, topic in sources.items():
            self._read.setdefault(topic, {})[sense] = None
        self._known = {topic: self._known.get(topic, _UNKNOWN) for topic in self._read}
        for sense in {**before, **sources}:
            value = self._value(sources[sense]) if sense in sources else None
            if before.get(sense) != value:
                yield Edge(sense, value, now)

    def take(self, topic: Topic, value: bool | None, now: float) -> Iterator[Edge]:
        """Take the value of a message; None if it has none."""
        if value is not None:
            yield from self._change(topic, _Known(value, now), now)

    def look(self, is_published: Callable[[str], bool], now: float) -> Iterator[Edge]:
        """Find topics that have become silent. A topic without a timeout is silent while it has no publisher."""
        late, self._looked = now > self._looked + 2 * LOOK, now
        if late:
            return  # this process stalled and hasn't yet read the messages that arrived meanwhile
        for topic, (value, at) in list(self._known.items()):
            if topic.timeout:
                if value is not None and now >= at + topic.timeout:
                    yield from self._change(topic, _UNKNOWN, now)
            elif not is_published(topic.topic):
                yield from self._change(topic, _UNKNOWN, now)
            elif value is None:
                yield from self._change(topic, _Known(False, now), now)

    def _value(self, topic: Topic) -> bool | None:
        return self._known.get(topic, _UNKNOWN).value

    def _change(self, topic: Topic, known: _Known, now: float) -> Iterator[Edge]:
        before, self._known[topic] = self._value(topic), known
        if before != known.value:
            yield from (Edge(sense, known.value, now) for sense in self._read.get(topic, ()))


class _Known(NamedTuple):
    """The latest value of a topic, and its time."""

    value: bool | None
    at: float


_UNKNOWN = _Known(None, -math.inf)


def _pose(measured: RawPose) -> MeasuredPose:
    robot, source, pose, at, frame, stamp, topic, _ = measured
    found = to_pose_json(pose)
    return {
        "robot": robot, "source": source, "pose": found, "at": at, "frame": frame, "stamp": stamp, "topic": topic
    }  # fmt: skip
