"""The poses of robots in ROS messages. Standard library only."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from improv_core.outputs.cdr import POSE_TEXTS, SECOND, Transform, frame_in, pose_in, stamp_in, transforms_in
from improv_core.outputs.ros.sensors.polled import STATIC, TF, Polled
from improv_core.protocol.output import RawPose
from improv_core.score.motion import Pose

KINDS = {**dict.fromkeys(POSE_TEXTS, 1), TF: 100}
"""The messages with poses, and how many of each topic may wait: several nodes send transforms on one topic."""
LONGEST_CHAIN = 20
"""The most transforms between two frames. More would be a circle."""
LONGEST_WAIT = SECOND
"""The longest that a message may have waited, in nanoseconds. Beyond it, the clocks don't agree."""


class PoseReader:
    """The latest poses of robots; `bases` are the names of their own frames in tf."""

    def __init__(self) -> None:
        self.bases: Mapping[str, str] = {}
        self._trees: dict[str, FrameTree] = {}  # by topic

    def take(self, polled: Iterable[Polled]) -> list[RawPose]:
        """Return the latest pose of each robot, if it is new."""
        found = []
        for robots, topic, kind, messages in polled:
            message, about = messages[-1]
            at = _arrived(about)
            if kind == TF:
                tree = self._trees.setdefault(topic, FrameTree())
                tree.take(messages)
                alone = len(robots) == 1
                for robot in robots:
                    if seen := tree.pose(self.bases.get(robot, robot), alone=alone):
                        pose, root, moved = seen
                        found.append(RawPose(robot, kind, pose, at, root, moved, topic))
            elif measured := pose_in(message, POSE_TEXTS[kind]):
                frame, stamp = frame_in(message), _stamped(stamp_in(message))
                found += [RawPose(robot, kind, measured, at, frame, stamp, topic) for robot in robots]
        return found


class FrameTree:
    """The latest transforms of a tree of frames."""

    def __init__(self) -> None:
        self._latest: dict[str, Transform] = {}  # by the child
        self._fixed: set[str] = set()  # children that never move in their parents
        self._seen: dict[str, int] = {}  # the stamps of the poses that were returned

    def take(self, messages: Sequence[tuple[bytes, Mapping[str, Any]]]) -> None:
        """Take messages of a topic, and of the one for transforms that never change."""
        for message, about in messages:
            for each in transforms_in(message):
                child = each.child.removeprefix("/")
                self._latest[child] = each
                (self._fixed.add if about.get(STATIC) else self._fixed.discard)(child)

    def pose(self, base: str, *, alone: bool) -> tuple[Pose, str, float | None] | None:
        """Return the pose of a robot's frame in the root of the tree, the name of the root, and the time of the latest
        movement; None if it isn't known or has been returned. The frame is `NAME/base_link`, or `base_link` if the
        topic has this robot `alone`."""
        frame = base if base in self._latest or not alone else base.rpartition("/")[2]
        pose, moved, began = Pose(), 0, frame
        for _ in range(LONGEST_CHAIN):
            if not (up := self._latest.get(frame)):
                break
            pose, moved = up.pose.then(pose), moved if moved or frame in self._fixed else up.stamp
            frame = up.parent.removeprefix("/")
        else:
            return None
        if frame == began or self._seen.get(began) == moved:
            return None
        self._seen[began] = moved
        return replace(pose, heading=math.remainder(pose.heading, math.tau)), frame, _stamped(moved)


def _arrived(about: Mapping[str, Any]) -> float:
    """The time of arrival of a message, on the monotonic clock. Its stamp may come from another machine's clock."""
    waited = time.time_ns() - (about.get("received_timestamp") or 0)
    return time.monotonic() - (waited / SECOND if 0 <= waited <= LONGEST_WAIT else 0.0)


def _stamped(stamp: int) -> float | None:
    """A stamp in nanoseconds, on the monotonic clock, as if the sender's clock were ours. None if it is 0."""
    return time.monotonic() + (stamp - time.time_ns()) / SECOND if stamp else None
