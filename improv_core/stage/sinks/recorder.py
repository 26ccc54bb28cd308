"""Velocities to a file: MCAP, as `ros2 bag play` and Foxglove read it (mcap, imported lazily)."""

from __future__ import annotations

import math
import struct
from collections.abc import Collection, Mapping
from typing import IO

from improv_core.score.motion import Pose, Twist
from improv_core.score.profiles import Profile
from improv_core.score.score import Score

SECOND = 1_000_000_000
"""Nanoseconds."""

_VECTOR3 = "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z"
_TWIST = "Vector3 linear\nVector3 angular"
_HEADER = "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id"
_TIME = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec"
_BETWEEN = f"\n{'=' * 80}\n"
SCHEMAS = {
    "Twist": _BETWEEN.join([_TWIST, _VECTOR3]),
    "TwistStamped": _BETWEEN.join(
        ["std_msgs/Header header\nTwist twist", f"MSG: geometry_msgs/Twist\n{_TWIST}", _VECTOR3, _HEADER, _TIME]
    ),
}
"""Each message and all that it is made of, in the order and with the lines of 80 `=` that `ros2msg` asks for."""

# CDR, little-endian (OMG DDS-XTypes 1.3, 7.4.1): after four bytes that say so, each field is aligned to its own size.
# An empty string is its length, 1, and a zero byte; three more align the first float64.
_CDR = b"\x00\x01\x00\x00"
_CDR_TWIST = struct.Struct("<4s6d")
_CDR_STAMPED = struct.Struct("<4siII4x6d")

# What sinks/ros.py offers: keep last 10, reliable, volatile. In numbers, as rosbag2 writes them up to Iron: later
# releases understand both forms, and Humble only this one. A duration of 9223372036.854775807 s is endless.
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


class Recorder:
    """A sink that writes what robots are told, within the limits of their profiles, on their topics.

    `start` is the Unix time of beat 0, in nanoseconds. `finish` completes the file, which the caller closes. It is
    written in chunks of 1 MiB; in memory, only the index grows, by some hundred bytes for each.
    """

    name: str = "recorder"
    period: float | None = None
    real = False

    def __init__(self, file: IO[bytes], start: int) -> None:
        from mcap.writer import Writer

        self._writer = Writer(file)
        self._writer.start(profile="ros2")
        self._start = start
        self._robots: dict[str, tuple[Profile, int]] = {}  # with the channel of each
        self._channels: dict[tuple[str, str], int] = {}
        self._schemas: dict[str, int] = {}
        self._times: tuple[int, int] | None = None
        self.setpoints = 0
        """How many have been recorded."""

    @property
    def robots(self) -> int:
        """How many have been prepared."""
        return len(self._robots)

    @property
    def seconds(self) -> float:
        """From the first command to the last."""
        return (self._times[1] - self._times[0]) / SECOND if self._times else 0.0

    def prepare(self, score: Score, restart: bool) -> None:
        for robot, part in score.parts.items():
            kind = "TwistStamped" if part.profile.message == "TwistStamped" else "Twist"
            self._robots[robot] = part.profile, self._channel(part.topic, kind)

    def resetting(self) -> bool:
        return False

    def missing(self, robots: Collection[str] | None = None) -> dict[str, str]:
        return {}

    def warnings(self, robots: Collection[str] | None = None) -> dict[str, str]:
        return {}

    def send(self, robot: str, twist: Twist, at: float) -> None:
        self.record(robot, twist, self._start + round(at * SECOND))

    def record(self, robot: str, twist: Twist, time: int) -> None:
        """A command as of a Unix time in nanoseconds. Raises ValueError if it is no number, OSError."""
        if not all(map(math.isfinite, (twist.x, twist.y, twist.z, twist.yaw))):
            raise ValueError(f"{robot} was given a speed that is not a finite number")
        profile, channel = self._robots[robot]
        told = twist.within(profile.max_linear, profile.max_angular)
        velocity = told.x, told.y, told.z, 0.0, 0.0, told.yaw
        if profile.message == "TwistStamped":
            data = _CDR_STAMPED.pack(_CDR, *divmod(time, SECOND), 1, *velocity)
        else:
            data = _CDR_TWIST.pack(_CDR, *velocity)
        self._writer.add_message(channel, log_time=time, publish_time=time, data=data)
        first, last = self._times or (time, time)
        self._times = min(first, time), max(last, time)
        self.setpoints += 1

    def place(self, poses: Mapping[str, Pose]) -> None:
        """Nothing: a recording has velocities alone."""

    def advance(self, to: float) -> None:
        """Nothing: what is sent is all there is."""

    def coasting(self) -> bool:
        return False

    def poses(self) -> dict[str, Pose]:
        return {}

    def finish(self) -> None:
        """Write what comes last: the index, without which the file can't be played. Raises OSError."""
        self._writer.finish()  # type: ignore[no-untyped-call]

    def close(self) -> None:
        """Nothing: the file is the caller's."""

    def _channel(self, topic: str, kind: str) -> int:
        if kind not in self._schemas:
            name = f"geometry_msgs/msg/{kind}"
            self._schemas[kind] = self._writer.register_schema(name, "ros2msg", SCHEMAS[kind].encode())
        if (topic, kind) not in self._channels:
            offered = {"offered_qos_profiles": OFFERED_QOS_PROFILES}
            self._channels[topic, kind] = self._writer.register_channel(topic, "cdr", self._schemas[kind], offered)
        return self._channels[topic, kind]
