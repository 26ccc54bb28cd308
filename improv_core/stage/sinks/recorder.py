"""Records velocities in an MCAP file that `ros2 bag play` and Foxglove can read (mcap, imported lazily)."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Collection, Mapping
from typing import IO

from improv_core.score.motion import Pose, Twist
from improv_core.score.profiles import Profile
from improv_core.score.score import Score
from improv_core.score.senses import RobotSense
from improv_core.stage.protocol import Decided, Sensed, read_from_stage
from improv_core.stage.sinks import Edge
from improv_core.stage.sinks.cdr import SECOND, frame_field, stamped, string_message, string_of, twist_message

_VECTOR3 = "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z"
_TWIST = "Vector3 linear\nVector3 angular"
_HEADER = "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id"
_TIME = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec"
_BETWEEN = f"\n{'=' * 80}\n"
SCHEMAS = {
    "String": "string data",
    "Twist": _BETWEEN.join([_TWIST, _VECTOR3]),
    "TwistStamped": _BETWEEN.join(
        ["std_msgs/Header header\nTwist twist", f"MSG: geometry_msgs/Twist\n{_TWIST}", _VECTOR3, _HEADER, _TIME]
    ),
}
"""Each message and its components, in the order and with the lines of 80 `=` that `ros2msg` requires."""

# What sinks/ros.py offers: keep last 10, reliable, volatile. Written as numbers, as in rosbag2 up to Iron: later
# releases understand both forms, Humble only this one. A duration of 9223372036.854775807 s means infinite.
_ENDLESS = "{sec: 9223372036, nsec: 854775807}"
OFFERED_QOS_PROFILES = f"""\
- history: 1
  depth: 10
  reliability: 1
  durability: 2
  deadline: {_ENDLESS}
  lifespan: {_ENDLESS}
  liveliness: 1
  liveliness_lease_duration: {_ENDLESS}
  avoid_ros_namespace_conventions: false
"""


CHANNELS = {"sensed": "/improv/sensed", "decided": "/improv/decided"}
"""The topics of what was sensed and what was decided: JSON in a `std_msgs/String`, so that ROS 2 can play it too."""


def sensed_in(file: IO[bytes]) -> list[Sensed]:
    """What was sensed in a recording, up to the first restart. Raises ValueError if it can't be read."""
    from mcap.exceptions import McapError
    from mcap.reader import make_reader

    try:
        messages = [message for *_, message in make_reader(file).iter_messages(topics=[CHANNELS["sensed"]])]
    except (McapError, struct.error):
        raise ValueError("it is not a recording") from None
    sensed: list[Sensed] = []
    for message in messages:
        edge = read_from_stage(string_of(message.data).encode())
        if edge["type"] == "sensed" and edge["generation"] == (sensed[0] if sensed else edge)["generation"]:
            sensed.append(edge)
    return sensed


class Recorder:
    """A sink that records the robots' commands on their topics, within the limits of their profiles.

    `start` is the Unix time of beat 0, in nanoseconds. `finish` completes the file, which the caller closes. It is
    written in chunks of 1 MiB. Only the index is kept in memory, about a hundred bytes per chunk.
    """

    name: str = "recorder"
    period: float | None = None
    real = False

    def __init__(self, file: IO[bytes], start: int) -> None:
        from mcap.writer import Writer

        self._writer = Writer(file)
        self._writer.start(profile="ros2")
        self._start = start
        self._robots: dict[str, tuple[Profile, bytes, int]] = {}  # and the frame and the channel of each
        self._channels: dict[tuple[str, str], int] = {}
        self._schemas: dict[str, int] = {}
        self._times: tuple[int, int] | None = None
        self.setpoints = 0
        """The number of setpoints recorded."""

    @property
    def robots(self) -> int:
        """The number of robots prepared."""
        return len(self._robots)

    @property
    def seconds(self) -> float:
        """The time from the first command to the last."""
        return (self._times[1] - self._times[0]) / SECOND if self._times else 0.0

    def meet(self, score: Score) -> None:
        """Does nothing: a recording has all that is sent."""

    def prepare(self, score: Score, restart: bool) -> None:
        for robot, part in score.parts.items():
            kind = "TwistStamped" if part.profile.message == "TwistStamped" else "Twist"
            self._robots[robot] = part.profile, frame_field(part.frame), self._channel(part.topic, kind)

    def resetting(self) -> bool:
        return False

    def missing(self, robots: Collection[str] | None = None) -> dict[str, str]:
        return {}

    def warnings(self, robots: Collection[str] | None = None) -> dict[str, str]:
        return {}

    def send(self, robot: str, twist: Twist, at: float) -> None:
        self.record(robot, twist, self.time(at))

    def record(self, robot: str, twist: Twist, time: int) -> None:
        """Record a command at a Unix time in nanoseconds. Raises ValueError if it is not finite, and OSError."""
        if not all(map(math.isfinite, (twist.x, twist.y, twist.z, twist.yaw))):
            raise ValueError(f"{robot} was given a speed that is not a finite number")
        profile, frame, channel = self._robots[robot]
        data = twist_message(twist.within(profile.max_linear, profile.max_angular))
        if profile.message == "TwistStamped":
            data = stamped(data, time, frame)
        self._writer.add_message(channel, log_time=time, publish_time=time, data=data)
        first, last = self._times or (time, time)
        self._times = min(first, time), max(last, time)
        self.setpoints += 1

    def time(self, at: float) -> int:
        """The Unix time in nanoseconds of a performance time."""
        return self._start + round(at * SECOND)

    def note(self, message: Sensed | Decided, time: int) -> None:
        """Record what was sensed or decided, as JSON, at a Unix time in nanoseconds. Raises OSError."""
        channel = self._channel(CHANNELS[message["type"]], "String")
        data = string_message(json.dumps(message))
        self._writer.add_message(channel, log_time=time, publish_time=time, data=data)

    def place(self, poses: Mapping[str, Pose]) -> None:
        """Does nothing: a recording contains only velocities."""

    def advance(self, to: float) -> None:
        """Does nothing: a recording contains only what is sent."""

    def sensed(self, asked: Collection[RobotSense], to: float) -> list[Edge]:
        self.advance(to)
        return []

    def coasting(self) -> bool:
        return False

    def poses(self) -> dict[str, Pose]:
        return {}

    def finish(self) -> None:
        """Write the index at the end of the file, without which it can't be played. Raises OSError."""
        self._writer.finish()  # type: ignore[no-untyped-call]

    def close(self) -> None:
        """Does nothing: the file belongs to the caller."""

    def _channel(self, topic: str, kind: str) -> int:
        if kind not in self._schemas:
            name = f"std_msgs/msg/{kind}" if kind == "String" else f"geometry_msgs/msg/{kind}"
            self._schemas[kind] = self._writer.register_schema(name, "ros2msg", SCHEMAS[kind].encode())
        if (topic, kind) not in self._channels:
            offered = {"offered_qos_profiles": OFFERED_QOS_PROFILES}
            self._channels[topic, kind] = self._writer.register_channel(topic, "cdr", self._schemas[kind], offered)
        return self._channels[topic, kind]
