"""The poses of robots in ROS messages. Standard library only."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from typing import Any

from improv_core.outputs.cdr import SECOND, frame_in, pose_in, stamp_in
from improv_core.outputs.ros.sensors.polled import Polled
from improv_core.protocol.output import RawPose

TEXTS = {
    "nav_msgs/Odometry": 2,
    "geometry_msgs/PoseStamped": 1,
    "geometry_msgs/PoseWithCovarianceStamped": 1,
}
"""The messages with a pose after a stamp, and the number of texts (names of frames) in between."""
LONGEST_WAIT = SECOND
"""The longest that a message may have waited, in nanoseconds. Beyond it, the clocks don't agree."""


def poses_in(polled: Iterable[Polled]) -> list[RawPose]:
    """Return the latest pose of each robot, if it is new."""
    found = []
    for robots, topic, kind, messages in polled:
        message, about = messages[-1]
        if pose := pose_in(message, TEXTS[kind]):
            at, frame, stamp = _arrived(about), frame_in(message), _stamped(stamp_in(message))
            found += [RawPose(robot, kind, pose, at, frame, stamp, topic) for robot in robots]
    return found


def _arrived(about: Mapping[str, Any]) -> float:
    """The time of arrival of a message, on the monotonic clock. Its stamp may come from another machine's clock."""
    waited = time.time_ns() - (about.get("received_timestamp") or 0)
    return time.monotonic() - (waited / SECOND if 0 <= waited <= LONGEST_WAIT else 0.0)


def _stamped(stamp: int) -> float | None:
    """A stamp in nanoseconds, on the monotonic clock, as if the sender's clock were ours. None if it is 0."""
    return time.monotonic() + (stamp - time.time_ns()) / SECOND if stamp else None
